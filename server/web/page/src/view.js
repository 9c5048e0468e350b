// The 3D view: renderer, camera, objects and hands. z is up.

import {AmbientLight, Color, DirectionalLight, PerspectiveCamera, Raycaster, Scene, Spherical, Vector2, Vector3, WebGLRenderer} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {Arrows} from './arrows.js';
import {makeContext} from './context.js';
import {HandView, toolPlace} from './hand_view.js';
import {AT} from './messages.js';
import {Objects} from './objects.js';
import {Robots} from './robot.js';
import {Surfaces} from './surfaces.js';
import {Tools} from './tools.js';
import {roundDown} from './words.js';

const START = new Vector3(0.55, -1, 0.5).normalize();  // from where the camera looks at first
const MARGIN = 0.92;  // share of the view that the box takes
const FOLLOWING = 0.15;  // [s] in which the camera has made most of the way to the hand that it follows
const [place, step] = [new Vector3(), new Vector3()];

export class View {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.renderer = new WebGLRenderer({canvas, context: makeContext(canvas)});
    this.renderer.debug.checkShaderErrors = false;  // To ask for them waits for each shader.
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(32, 1, 0.001, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => (this.stale = true));
    const sun = new DirectionalLight(0xffffff, 2.2);
    sun.position.set(-0.5, 0.8, 1);
    this.camera.add(sun, sun.target);  // Light comes from beside the viewer, so that no side is ever black.
    this.scene.add(this.camera, new AmbientLight(0xffffff, 1.3));
    this.hands = new HandView();
    this.tools = new Tools();
    this.surfaces = new Surfaces();
    this.robots = new Robots();
    this.seats = [];  // names of the robots' seats
    this.scene.add(this.hands.group, this.tools.group, this.surfaces.mesh, this.robots.group);
    this.axes = new Arrows(this.scene, {width: 2, opacity: 1, order: 2});  // of the world
    this.origin = new Vector3();  // of the axes
    this.axisEnds = ['x', 'y', 'z'].map((name) => ({name, point: new Vector3()}));
    this.objects = null;
    this.frame = {center: new Vector3(), extent: new Vector3(0.1, 0.1, 0.1), size: 0.2};
    this.spacing = 0.02;  // [m] between the lines on planes
    this.perNewton = 0.02;  // [m] of arrow for a newton
    this.depthFactor = 5;
    this.picture = null;
    this.chosen = null;
    this.follows = false;  // whether the camera keeps the chosen hand in its middle
    this.colors = null;
    this.stale = true;
    this.frames = 0;
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    this.#resize();
  }

  /** @param {object} message the server's `scene` */
  setScene(message) {
    const sameName = this.objects?.name === message.name;
    const [low, high] = message.box ?? [[-0.1, -0.1, 0], [0.1, 0.1, 0.1]];
    const from = new Vector3(...low);
    const to = new Vector3(...high);
    this.frame = {center: from.clone().add(to).multiplyScalar(0.5), extent: to.clone().sub(from), size: Math.max(from.distanceTo(to), 1e-3)};
    this.spacing = roundDown(this.frame.size / 12);
    if (this.objects) {
      this.scene.remove(this.objects.group);
      this.objects.dispose();
    }
    this.objects = new Objects(message, this.frame, this.spacing);
    this.objects.name = message.name;
    this.tools.setTools(message.tools ?? []);
    this.seats = message.seats ?? [];
    this.surfaces.count = 0;
    this.surfaces.size = this.frame.size;
    this.scene.add(this.objects.group);
    this.#placeAxes(from);
    if (this.colors) this.objects.paint(this.colors);
    this.camera.near = 0.01 * this.frame.size;
    this.camera.far = 60 * this.frame.size;
    if (!sameName) {  // A reload leaves the camera and the scales where the user put them.
      this.perNewton = roundDown(0.1 * this.frame.size);
      this.hands.trails.clear();
      this.lookAtAll();
    }
    this.stale = true;
  }

  /** @param {object} geometry one object's, as readGeometry gives it */
  addGeometry(geometry) {
    this.objects?.add(geometry);
    this.stale = true;
  }

  /** @param {import('./messages.js').Picture} picture the newest */
  show(picture) {
    const elapsed = picture.time - (this.picture?.time ?? picture.time);
    this.picture = picture;
    if (this.follows) this.#follow(1 - Math.exp(-Math.max(elapsed, 0) / FOLLOWING));
    if (this.objects && picture.version === this.objects.version) this.objects.place(picture);
    this.hands.trail(picture);
    this.surfaces.grow();
    this.stale = true;
  }

  /** @param {object} colors of the theme */
  paint(colors) {
    this.colors = colors;
    this.scene.background = new Color(colors.view);
    this.hands.paint(colors);
    this.tools.paint(colors);
    this.surfaces.paint(colors);
    this.robots.paint(colors);
    this.axes.material.color.set(colors.ink);
    this.objects?.paint(colors);
    this.stale = true;
  }

  /** Draws, if anything changed. @returns {boolean} whether it did */
  render() {
    if (!this.stale) return false;
    this.stale = false;
    if (this.picture) {
      const how = this.#how();
      this.hands.show(this.picture, how);
      this.tools.show(this.picture, how);
      this.surfaces.show(this.chosen);
      this.robots.show(this.picture, how);
    }
    this.#showAxes();
    if (this.frames === 0 && this.picture) this.#renderFirst();
    else this.draw();
    this.frames += 1;
    return true;
  }

  /** Draws what the last picture showed. */
  draw() {
    this.renderer.render(this.scene, this.camera);
  }

  /** [N] of all forces that are drawn as arrows. */
  get strongest() {
    return Math.max(this.hands.strongest, this.robots.strongest);
  }

  /** The first picture has the objects, the hands and their forces. What needs more shaders comes with the next frame. */
  #renderFirst() {
    const later = [this.surfaces.mesh, this.hands.trails.mesh, this.hands.discs.mesh, ...this.objects?.edges.values() ?? []].filter(({visible}) => visible);
    for (const mesh of later) mesh.visible = false;
    this.draw();
    for (const mesh of later) mesh.visible = true;
    this.stale = later.length > 0;
  }

  /** Puts the camera where the whole box is seen, from the side that `direction` points to. @param {{center: Vector3, extent: Vector3}} frame the box */
  lookAtAll(direction = START, frame = this.frame) {
    const {camera, controls} = this;
    const slope = MARGIN * Math.tan((camera.fov * Math.PI) / 360);
    const across = new Vector3().crossVectors(camera.up, direction).normalize();
    const upward = new Vector3().crossVectors(direction, across);
    let distance = 0;
    for (let i = 0; i < 8; ++i) {
      place.set(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5).multiply(frame.extent);
      const lateral = Math.max(Math.abs(place.dot(across)) / camera.aspect, Math.abs(place.dot(upward)));
      distance = Math.max(distance, place.dot(direction) + lateral / slope);
    }
    controls.target.copy(frame.center);
    camera.position.copy(frame.center).addScaledVector(direction, distance);
    controls.update();
    this.stale = true;
  }

  /** Shows the whole box, and the hands that are outside of it. */
  lookAtAllHands() {
    const half = this.frame.extent.clone().multiplyScalar(0.5);
    const [low, high] = [this.frame.center.clone().sub(half), this.frame.center.clone().add(half)];
    for (let i = 0; i < (this.picture?.hands ?? 0); ++i) {
      place.fromArray(this.picture.floats, this.picture.handAt(i) + AT.proxy);
      low.min(place);
      high.max(place);
    }
    this.lookAtAll(START, {center: low.clone().add(high).multiplyScalar(0.5), extent: high.sub(low)});
  }

  /** The place of the camera, and the point that it looks at [m]. @type {import('./link.js').Pose} */
  get pose() {
    return {position: this.camera.position.toArray(), target: this.controls.target.toArray()};
  }

  set pose({position, target}) {
    this.camera.position.fromArray(position);
    this.controls.target.fromArray(target);
    this.controls.update();
    this.stale = true;
  }

  /** @param {'x' | 'y' | 'z'} axis to look along */
  lookAlong(axis) {
    this.lookAtAll({x: new Vector3(1, 0, 0), y: new Vector3(0, -1, 0), z: new Vector3(0, -1e-4, 1)}[axis]);
  }

  /** Turns the camera about what it looks at. Angles in radians. */
  turn(azimuth, polar) {
    const {camera, controls} = this;
    const offset = camera.position.clone().sub(controls.target);
    const spherical = new Spherical().setFromCartesianCoords(offset.x, offset.z, -offset.y);  // three's has y up
    spherical.theta += azimuth;
    spherical.phi = Math.min(Math.max(spherical.phi + polar, 0.01), Math.PI - 0.01);
    offset.setFromSpherical(spherical);
    camera.position.set(offset.x, -offset.z, offset.y).add(controls.target);
    controls.update();
    this.stale = true;
  }

  /** @param {number} factor above 1 goes nearer */
  zoom(factor) {
    this.camera.position.sub(this.controls.target).divideScalar(factor).add(this.controls.target);
    this.controls.update();
    this.stale = true;
  }

  /** Moves the camera so that a hand is in the middle. @param {number} number */
  lookAtHand(number) {
    const i = this.placeOf(number);
    if (i < 0) return;
    toolPlace(this.picture, i, this.depthFactor, place);
    this.#shift(step.copy(place).sub(this.controls.target));
  }

  /**
   * Where hand i of the picture is seen.
   * @param {number} i @param {{x: number, y: number, seen: boolean}} result in pixels of the page, from the canvas' corner
   */
  project(i, result) {
    toolPlace(this.picture, i, this.depthFactor, place);
    return this.projectPoint(place, result);
  }

  /** @param {Vector3} point */
  projectPoint(point, result) {
    place.copy(point).project(this.camera);
    result.x = (0.5 + 0.5 * place.x) * this.width;
    result.y = (0.5 - 0.5 * place.y) * this.height;
    result.seen = place.z > -1 && place.z < 1 && Math.abs(place.x) < 1.1 && Math.abs(place.y) < 1.1;
    return result;
  }

  /** Where all hands are seen. */
  places() {
    return Array.from({length: this.picture?.hands ?? 0}, (_, i) => (
      {number: this.picture.words[this.picture.handAt(i) + AT.number], ...this.project(i, {x: 0, y: 0, seen: false})}));
  }

  /** @returns {number | null} number of the hand that is seen nearest to a place of the canvas */
  handAt(x, y, reach = 40) {
    let best = reach;
    let found = null;
    for (let i = 0; i < (this.picture?.hands ?? 0); ++i) {
      const at = this.project(i, {x: 0, y: 0, seen: false});
      const away = Math.hypot(at.x - x, at.y - y);
      if (!at.seen || away >= best) continue;
      best = away;
      found = this.picture.words[this.picture.handAt(i) + AT.number];
    }
    return found;
  }

  /** Where the first few bodies that move are drawn: in the world and on the canvas. For tests. */
  bodyPlaces() {
    return (this.objects?.places() ?? []).map((body) => ({...body, ...this.projectPoint(new Vector3(...body.at), {x: 0, y: 0, seen: false})}));
  }

  /**
   * The moving body that is seen at a place of the canvas, and the ray to it.
   * @returns {{index: number, point: Vector3, direction: Vector3} | null}
   */
  bodyAt(x, y) {
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((2 * x) / this.width - 1, 1 - (2 * y) / this.height), this.camera);
    const body = this.objects?.bodyOn(ray);
    return body ? {...body, direction: ray.ray.direction} : null;
  }

  /** @param {number | null} number of a hand @returns {number} its place in the picture; negative: it is not there */
  placeOf(number) {
    return number === null ? -1 : this.#indexOf(number);
  }

  /** Size of a pixel [m] at the distance of what the camera looks at. */
  get pixel() {
    const distance = this.camera.position.distanceTo(this.controls.target);
    return (2 * distance * Math.tan((this.camera.fov * Math.PI) / 360)) / this.height;
  }

  /** The axes of the world at a corner of the box, each as long as two lines of the grid are apart. */
  #placeAxes(corner) {
    this.origin.copy(corner);
    this.axisEnds.forEach(({point}, axis) => point.copy(corner).setComponent(axis, corner.getComponent(axis) + 2 * this.spacing));
  }

  #showAxes() {
    this.axes.clear();
    if (this.objects) for (const {point} of this.axisEnds) this.axes.add(this.origin, step.copy(point).sub(this.origin), this.pixel);
    this.axes.done();
  }

  /** @param {number} share of the way to the chosen hand that the camera makes now */
  #follow(share) {
    const i = this.placeOf(this.chosen);
    if (i < 0) return;
    toolPlace(this.picture, i, this.depthFactor, place);
    this.#shift(step.copy(place).sub(this.controls.target).multiplyScalar(share));
  }

  /** Moves the camera and what it looks at. */
  #shift(way) {
    this.camera.position.add(way);
    this.controls.target.add(way);
    this.controls.update();
    this.stale = true;
  }

  #how() {
    return {chosen: this.chosen, perNewton: this.perNewton, depthFactor: this.depthFactor, pixel: this.pixel, tools: this.tools, surfaces: this.surfaces};
  }

  #indexOf(number) {
    for (let i = 0; i < (this.picture?.hands ?? 0); ++i) {
      if (this.picture.words[this.picture.handAt(i) + AT.number] === number) return i;
    }
    return -1;
  }

  #resize() {
    const {clientWidth, clientHeight} = this.canvas.parentElement;
    const [width, height, ratio] = [Math.max(clientWidth, 1), Math.max(clientHeight, 1), Math.min(devicePixelRatio, 2)];
    if (width === this.width && height === this.height && ratio === this.renderer.getPixelRatio()) return;  // Else the canvas is made anew.
    [this.width, this.height] = [width, height];
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height);
    this.camera.aspect = this.width / this.height;
    this.camera.updateProjectionMatrix();
    this.stale = true;
  }
}
