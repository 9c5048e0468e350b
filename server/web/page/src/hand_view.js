// Hands in the 3D view: tool, proxy, the way between them, contact, forces and trails.

import {CircleGeometry, Group, LatheGeometry, MeshBasicMaterial, MeshLambertMaterial, Quaternion, SphereGeometry, Vector2, Vector3} from 'three';
import {Arrows, rodShape} from './arrows.js';
import {AT, length3} from './messages.js';
import {Pool} from './pool.js';
import {Trails} from './trails.js';

const NORMAL = 34;  // [px] of the line along the normal of a contact
const TOUCH = 1e-3;  // [N] from which a hand counts as touching

// A pen whose tip is at the origin and whose body is along z, in pixels.
const pen = new LatheGeometry([[0, 0], [4.5, 16], [4.5, 74], [3.5, 76], [0, 76]].map(([x, y]) => new Vector2(x, y)), 16).rotateX(Math.PI / 2);
const ball = new SphereGeometry(1, 16, 12);
const disc = new CircleGeometry(1, 32);

const [proxy, tool, vector, normal, scale] = Array.from({length: 5}, () => new Vector3());
const up = new Vector3(0, 0, 1);
const turn = new Quaternion();
const still = new Quaternion();
const entry = {number: 0, floats: null, at: 0};  // of a trail

/** All hands of a picture. */
export class HandView {
  constructor() {
    this.group = new Group();
    const flat = (opacity) => new MeshBasicMaterial({transparent: true, opacity, depthTest: false, depthWrite: false});
    this.discs = new Pool(disc, new MeshBasicMaterial({transparent: true, opacity: 0.28, depthTest: false, depthWrite: false, side: 2, forceSinglePass: true}), this.group, 2);
    this.pens = new Pool(pen, new MeshLambertMaterial({side: 2}), this.group, 3);
    this.rods = new Pool(rodShape, flat(1), this.group, 4);
    this.tips = new Pool(ball, flat(1), this.group, 8);
    this.proxies = new Pool(ball, flat(0.85), this.group, 4);
    this.normals = new Pool(rodShape, flat(1), this.group, 8);  // Before the arrow of an elastic force, which has the same direction.
    this.arrows = {
      rendered: new Arrows(this.group, {width: 10, opacity: 0.45, order: 5}),
      elastic: new Arrows(this.group, {width: 4.5, opacity: 1, order: 6}),
      friction: new Arrows(this.group, {width: 4.5, opacity: 1, order: 7}),
    };
    this.pools = [this.discs, this.pens, this.rods, this.tips, this.proxies, this.normals, ...Object.values(this.arrows)];
    this.trails = new Trails();
    this.group.add(this.trails.mesh);
    this.colors = {};
    this.longest = 0;  // [m] of all arrows of the last picture, as drawn
    this.strongest = 0;  // [N] of their forces
    this.contacts = [];  // {number, at, normal} of the last picture: number of the hand, [m], and of length 1
  }

  /** @param {{ink: string, muted: string, chosen: string, elastic: string, friction: string, rendered: string}} colors */
  paint(colors) {
    this.colors = colors;
    this.discs.material.color.set(colors.elastic);
    this.rods.material.color.set(colors.ink);
    this.proxies.material.color.set(colors.muted);
    this.normals.material.color.set(colors.ink);
    this.trails.paint(colors);
    for (const [kind, arrows] of Object.entries(this.arrows)) arrows.material.color.set(colors[kind]);
  }

  /**
   * @param {import('./messages.js').Picture} picture
   * @param {{chosen: number | null, perNewton: number, depthFactor: number, pixel: number, tools: import('./tools.js').Tools,
   *   surfaces: import('./surfaces.js').Surfaces}} how
   *   perNewton in metres, pixel in metres
   */
  show(picture, how) {
    for (const pool of this.pools) pool.clear();
    this.longest = this.strongest = 0;
    this.contacts = [];
    for (let i = 0; i < picture.hands; ++i) this.#showHand(picture, picture.handAt(i), how);
    for (const pool of this.pools) pool.done();
  }

  /** Adds the place of each hand to its trail, and forgets the trails of hands that left. */
  trail(picture) {
    entry.floats = picture.floats;
    this.trails.add(picture.hands, (i) => {
      const at = picture.handAt(i);
      entry.number = picture.words[at + AT.number];
      entry.at = at + AT.proxy;
      return entry;
    });
  }

  /** A disc in the surface, and a line along its normal. */
  #showContact(number, place, direction, pixel) {
    turn.setFromUnitVectors(up, direction);
    this.discs.add(place, turn, scale.setScalar(18 * pixel));
    this.normals.addAlong(place, vector.copy(direction).multiplyScalar(NORMAL * pixel), 0.7 * pixel);
    this.contacts.push({number, at: place.toArray(), normal: direction.toArray()});
  }

  #showHand(picture, at, how) {
    const {floats} = picture;
    const chosen = picture.words[at + AT.number] === how.chosen;
    const pixel = how.pixel;
    drawnPlace(floats, at, how.depthFactor, tool);
    const q = at + AT.orientation;
    turn.set(floats[q + 1], floats[q + 2], floats[q + 3], floats[q]);
    const tint = chosen ? this.colors.chosen : this.colors.muted;
    if (!how.tools.hasBody(picture.words[at + AT.number])) this.pens.add(tool, turn, scale.setScalar(pixel), tint);
    this.tips.add(tool, still, scale.setScalar(3 * pixel), tint);
    if (tool.distanceTo(proxy) > pixel) {
      this.rods.addAlong(proxy, vector.copy(tool).sub(proxy), 0.8 * pixel);
    }
    if (length3(floats, at + AT.elastic) > TOUCH) {
      this.proxies.add(proxy, still, scale.setScalar(3.5 * pixel));
      const number = picture.words[at + AT.number];
      const show = (place, direction) => this.#showContact(number, place, direction, pixel);
      // Without a local model the page knows no surface. An elastic force is along its normal.
      if (how.surfaces.touching(number, show) === 0) show(proxy, normal.fromArray(floats, at + AT.elastic).normalize());
    }
    for (const kind of ['rendered', 'elastic', 'friction']) {
      vector.fromArray(floats, at + AT[kind]);
      this.strongest = Math.max(this.strongest, vector.length());
      vector.multiplyScalar(how.perNewton);
      this.longest = Math.max(this.longest, vector.length());
      this.arrows[kind].add(proxy, vector, pixel);
    }
  }
}

/** Where a tool is drawn: as deep in the surface as it is, times a factor. Leaves the proxy in `proxy`. */
function drawnPlace(floats, at, depthFactor, result) {
  proxy.fromArray(floats, at + AT.proxy);
  return result.fromArray(floats, at + AT.position).sub(proxy).multiplyScalar(depthFactor).add(proxy);
}

/** The same for others: labels and picking. */
export function toolPlace(picture, i, depthFactor, result) {
  return drawnPlace(picture.floats, picture.handAt(i), depthFactor, result);
}
