// The objects of the scene: those at rest, those that move (few draw calls for all), planes and guides.

import {
  BackSide, BatchedMesh, BufferAttribute, BufferGeometry, Color, CurvePath, DoubleSide, EdgesGeometry, Group, InstancedMesh,
  LineBasicMaterial, LineCurve3, LineSegments, Matrix4, Mesh, MeshLambertMaterial, Quaternion, SphereGeometry, TubeGeometry, Vector3,
} from 'three';
import {withNormals} from './creases.js';
import {makeFloor} from './floor.js';
import {BODY_AT} from './messages.js';

// Tones of objects, in turns: quiet, so that the arrows stand out.
const TONES = [[0.62, 0.65, 0.7], [0.72, 0.63, 0.53], [0.58, 0.67, 0.6], [0.68, 0.6, 0.66], [0.56, 0.65, 0.72], [0.7, 0.67, 0.54]];
const CREASE = 35;  // [deg] between two faces from which the edge between them is drawn, so that depth is seen
const EDGED = {corners: 60_000, bodies: 64};  // An object with more has no edges, as bodies have none where there are more.
const MANY = 4;  // objects of one shape from which they are drawn together

/** All objects of one version of a scene. */
export class Objects {
  /**
   * @param {object} scene the server's message
   * @param {{center: Vector3, size: number}} frame
   * @param {number} spacing [m] of the lines on planes
   */
  constructor(scene, frame, spacing) {
    this.group = new Group();
    this.version = scene.version;
    const objects = scene.objects ?? [];
    this.described = new Map(objects.map((object) => [object.index, object]));
    this.planes = objects.filter((object) => object.plane).map((object) => makeFloor(object.plane, frame, spacing));
    this.guides = (scene.guides ?? []).map((guide) => makeGuide(guide, frame)).filter(Boolean);
    if (this.planes.length > 0) this.group.add(...this.planes);
    if (this.guides.length > 0) this.group.add(...this.guides);
    this.still = [];  // {index, geometry} of objects that do not move
    this.moving = new Map();  // object index -> BufferGeometry, shared by objects of one shape
    this.shapes = new Map();
    this.bodies = new Map();  // object index -> where it is drawn: an instance of a mesh
    this.meshes = [];  // of all moving objects
    this.changed = false;
    this.edges = new Map();  // object index -> lines
    this.edge = new LineBasicMaterial();
  }

  /** @param {{index: number, version: number, positions: Float32Array, corners: Uint32Array}} geometry */
  add(geometry) {
    const object = this.described.get(geometry.index);
    if (!object || geometry.version !== this.version || geometry.corners.length === 0) return;
    if (!object.moves) {
      const mesh = new InstancedMesh(makeGeometry(geometry), makeMaterial(object), 1);  // One copy: it needs no other shader than those that move.
      mesh.setColorAt(0, colorOf(object));
      this.still.push({index: geometry.index, geometry: mesh.geometry});
      this.group.add(mesh);
      this.#addEdges(geometry.index, mesh.geometry);
      return;
    }
    const key = shapeKey(geometry);
    if (!this.shapes.has(key)) this.shapes.set(key, makeGeometry(geometry));
    this.moving.set(geometry.index, this.shapes.get(key));
    this.changed = true;
  }

  /** Puts every moving body where the picture says. @param {import('./messages.js').Picture} picture */
  place(picture) {
    if (this.changed) this.#makeMeshes();
    const {floats, words} = picture;
    for (let i = 0; i < picture.bodies; ++i) {
      const at = picture.bodyAt(i);
      const body = this.bodies.get(words[at + BODY_AT.index]);
      if (body === undefined) continue;
      position.fromArray(floats, at + BODY_AT.position);
      const q = at + BODY_AT.orientation;
      turn.set(floats[q + 1], floats[q + 2], floats[q + 3], floats[q]);
      body.mesh.setMatrixAt(body.instance, matrix.compose(position, turn, one));
      const lines = this.edges.get(words[at + BODY_AT.index]);
      if (!lines) continue;
      lines.matrix.copy(matrix);
      lines.matrixWorldNeedsUpdate = lines.visible = true;
    }
    for (const mesh of this.meshes) if (mesh.instanceMatrix) mesh.instanceMatrix.needsUpdate = true;
  }

  /** @param {{surface: string, line: string, guide: string}} colors */
  paint(colors) {
    for (const plane of this.planes) {
      plane.material.uniforms.surface.value.set(colors.surface);
      plane.material.uniforms.line.value.set(colors.line);
    }
    for (const guide of this.guides) guide.material.color.set(colors.guide);
    this.edge.color.set(colors.muted);
  }

  /** @returns {{index: number, triangles: number, low: number[], high: number[]}[]} of the objects that have triangles and do not move */
  sizes() {
    return this.still.map(({index, geometry}) => {
      geometry.computeBoundingBox();
      const {min, max} = geometry.boundingBox;
      return {index, triangles: geometry.index.count / 3, low: min.toArray(), high: max.toArray()};
    });
  }

  /**
   * The body that a ray meets first, unless what is at rest is before it.
   * @param {import('three').Raycaster} ray @returns {{index: number, point: Vector3} | null}
   */
  bodyOn(ray) {
    for (const mesh of this.meshes) mesh.boundingSphere = mesh.boundingBox = null;  // Else it is where bodies were.
    const solid = this.group.children.filter((node) => node.isInstancedMesh || node.isBatchedMesh);
    const [hit] = ray.intersectObjects(solid, false);
    if (!hit || !this.meshes.includes(hit.object)) return null;
    const instance = hit.instanceId ?? hit.batchId;
    const [index] = [...this.bodies].find(([, body]) => body.mesh === hit.object && body.instance === instance);
    return {index, point: hit.point};
  }

  /** @returns {{index: number, triangles: number, at: number[]}[]} of the first few bodies that move: their origins as drawn */
  places() {
    return [...this.bodies].slice(0, 8).map(([index, {mesh, instance}]) => {
      mesh.getMatrixAt(instance, matrix);
      return {index, triangles: this.moving.get(index).index.count / 3, at: position.setFromMatrixPosition(matrix).toArray()};
    });
  }

  /** @returns {{index: number, segments: number}[]} of the objects whose edges are drawn */
  edgeCounts() {
    return [...this.edges].filter(([, {visible}]) => visible).map(([index, {geometry}]) => ({index, segments: geometry.attributes.position.count / 2}));
  }

  dispose() {
    this.group.traverse((node) => {
      node.geometry?.dispose();
      node.material?.dispose();
      if (node !== this.group) node.dispose?.();
    });
    for (const shape of this.shapes.values()) shape.dispose();
  }

  #makeMeshes() {
    this.changed = false;
    for (const mesh of this.meshes) {
      this.group.remove(mesh);
      mesh.material.dispose();
      mesh.dispose();
    }
    this.bodies.clear();
    for (const index of this.moving.keys()) this.#removeEdges(index);
    const alike = new Map();  // shape -> indices of its objects
    for (const [index, shape] of this.moving) {
      if (!alike.has(shape)) alike.set(shape, []);
      alike.get(shape).push(index);
    }
    const groups = [...alike];
    this.meshes = groups.filter(([, indices]) => indices.length >= MANY).map(([shape, indices]) => this.#makeInstances(shape, indices));
    const others = groups.filter(([, indices]) => indices.length < MANY);
    if (others.length > 0) this.meshes.push(this.#makeBatch(others));
    for (const mesh of this.meshes) mesh.frustumCulled = false;
    this.group.add(...this.meshes);
    if (this.moving.size > EDGED.bodies) return;
    for (const [index, shape] of this.moving) {
      const lines = this.#addEdges(index, shape);
      if (lines) lines.visible = lines.matrixAutoUpdate = false;  // Until a picture says where it is.
    }
  }

  /** @returns {LineSegments | null} null: the object has no edges */
  #addEdges(index, shape) {
    if (shape.index.count > EDGED.corners) return null;
    const geometry = new EdgesGeometry(shape, CREASE);
    if (geometry.attributes.position.count === 0) return null;
    const lines = new LineSegments(geometry, this.edge);
    this.edges.set(index, lines);
    this.group.add(lines);
    return lines;
  }

  #removeEdges(index) {
    const lines = this.edges.get(index);
    if (!lines) return;
    this.edges.delete(index);
    this.group.remove(lines);
    lines.geometry.dispose();
  }

  /** Objects of one shape. */
  #makeInstances(shape, indices) {
    const mesh = new InstancedMesh(shape, makeMaterial(), indices.length);
    indices.forEach((index, instance) => this.#addBody(mesh, instance, index));
    return mesh;
  }

  /** Objects of many shapes. */
  #makeBatch(groups) {
    let [instances, vertices, corners] = [0, 0, 0];
    for (const [shape, indices] of groups) {
      instances += indices.length;
      vertices += shape.attributes.position.count;
      corners += shape.index.count;
    }
    const mesh = new BatchedMesh(instances, vertices, corners, makeMaterial());
    mesh.perObjectFrustumCulled = false;
    mesh.sortObjects = false;
    for (const [shape, indices] of groups) {
      const id = mesh.addGeometry(shape);
      for (const index of indices) this.#addBody(mesh, mesh.addInstance(id), index);
    }
    return mesh;
  }

  #addBody(mesh, instance, index) {
    mesh.setColorAt(instance, colorOf(this.described.get(index)));
    mesh.setMatrixAt(instance, nowhere);  // Until a picture says where it is.
    this.bodies.set(index, {mesh, instance});
  }
}

const position = new Vector3();
const one = new Vector3(1, 1, 1);
const turn = new Quaternion();
const matrix = new Matrix4();
const nowhere = new Matrix4().makeScale(0, 0, 0);

// An object felt from within, such as a room, is drawn as seen from within: near walls do not hide its content.
const makeMaterial = (object) => new MeshLambertMaterial({
  side: object?.felt_from === 'inside' ? BackSide : DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,  // Edges lie before faces.
});

function colorOf(object) {
  return new Color().setRGB(...TONES[object.index % TONES.length], 'srgb');
}

function makeGeometry({positions, corners}) {
  const made = withNormals(positions, corners);
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(made.positions, 3));
  geometry.setAttribute('normal', new BufferAttribute(made.normals, 3));
  geometry.setIndex(new BufferAttribute(made.corners, 1));
  return geometry;
}

/** Objects of one shape have one key; FNV-1a over all numbers, with the counts beside it. */
function shapeKey({positions, corners}) {
  let hash = 0x811c9dc5;
  const bits = new Uint32Array(positions.buffer, positions.byteOffset, positions.length);
  for (const word of bits) hash = Math.imul(hash ^ word, 0x01000193);
  for (const word of corners) hash = Math.imul(hash ^ word, 0x01000193);
  return `${positions.length}/${corners.length}/${hash >>> 0}`;
}

/** One can be seen through. @returns {Mesh | null} null: it acts everywhere */
function makeGuide(guide, frame) {
  const points = (guide.points ?? []).map((point) => new Vector3(...point));
  const radius = 0.004 * frame.size;
  const material = new MeshLambertMaterial({transparent: true, opacity: 0.35, depthWrite: false, side: DoubleSide});
  if (guide.triangles?.length > 0) {
    return new Mesh(makeGeometry({positions: Float32Array.from(guide.vertices.flat()), corners: Uint32Array.from(guide.triangles.flat())}), material);
  }
  if (points.length === 0) return null;
  if (points.length === 1) {
    const ball = new Mesh(new SphereGeometry(radius, 24, 16), material);
    ball.position.copy(points[0]);
    return ball;
  }
  const path = new CurvePath();
  if (guide.closed) points.push(points[0]);
  for (let i = 1; i < points.length; ++i) path.add(new LineCurve3(points[i - 1], points[i]));
  return new Mesh(new TubeGeometry(path, 24 * (points.length - 1), radius, 12), material);
}
