// Local models: the surfaces that a client knows near its tool, and renders by itself. Each is drawn as a piece around its point.

import {BufferAttribute, BufferGeometry, DynamicDrawUsage, Mesh, MeshBasicMaterial, Vector3} from 'three';

const HEADER_WORDS = 3;
const PATCH_WORDS = 15;
const AT = {hand: 0, flags: 1, point: 2, normal: 5, axis: 8, curvature: 11, radius: 12, reach: 13};
const MOST = 48;  // patches that are drawn: three of each of 16 hands
const RINGS = 3;
const AROUND = 24;
const CORNERS = 1 + RINGS * AROUND;
const SHARE = 0.06;  // of the scene's size: no piece is drawn larger
const OLD = 20;  // pictures after which a patch that did not come again is gone

const [point, normal, axis, across, along, place] = Array.from({length: 6}, () => new Vector3());

export class Surfaces {
  constructor() {
    const geometry = new BufferGeometry();
    this.places = new BufferAttribute(new Float32Array(3 * CORNERS * MOST), 3).setUsage(DynamicDrawUsage);
    this.colors = new BufferAttribute(new Float32Array(4 * CORNERS * MOST), 4).setUsage(DynamicDrawUsage);
    geometry.setAttribute('position', this.places);
    geometry.setAttribute('color', this.colors);
    geometry.setIndex(cornersOf(MOST));
    this.mesh = new Mesh(geometry, new MeshBasicMaterial({vertexColors: true, transparent: true, depthTest: false, depthWrite: false, side: 2, forceSinglePass: true}));
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 1;
    this.words = null;
    this.floats = null;
    this.count = 0;
    this.age = 0;
    this.size = 0.2;  // [m] of the scene
    this.shown = true;
  }

  /** @param {ArrayBuffer} buffer a whole message of kind 3 @returns {boolean} false if it is malformed; all is then as it was */
  read(buffer) {
    if (buffer.byteLength < 4 * HEADER_WORDS || buffer.byteLength % 4 !== 0) return false;
    const words = new Uint32Array(buffer);
    if (words.length < HEADER_WORDS + PATCH_WORDS * words[2]) return false;
    this.words = words;
    this.floats = new Float32Array(buffer);
    this.count = Math.min(words[2], MOST);
    this.age = 0;
    return true;
  }

  /** @param {object} colors of the theme */
  paint(colors) {
    this.mesh.material.color.set(colors.guide);
  }

  /** A picture came. */
  grow() {
    this.age += 1;
    if (this.age > OLD) this.count = 0;
  }

  /**
   * Calls `each` with the point and the normal of every surface that a hand touches; the next call has the same two vectors.
   * @param {number} number of the hand @param {(point: Vector3, normal: Vector3) => void} each @returns {number} how many these are
   */
  touching(number, each) {
    let found = 0;
    for (let i = 0; i < this.count; ++i) {
      const at = HEADER_WORDS + PATCH_WORDS * i;
      if (this.words[at + AT.hand] !== number || !(this.words[at + AT.flags] & 1)) continue;
      each(point.fromArray(this.floats, at + AT.point), normal.fromArray(this.floats, at + AT.normal));
      found += 1;
    }
    return found;
  }

  /** Writes all patches anew. @param {number | null} chosen hand, whose patches stand out */
  show(chosen) {
    this.mesh.visible = this.shown && this.count > 0;
    if (!this.mesh.visible) return;
    for (let i = 0; i < this.count; ++i) this.#write(i, HEADER_WORDS + PATCH_WORDS * i, chosen);
    this.mesh.geometry.setDrawRange(0, this.count * (this.mesh.geometry.index.count / MOST));
    this.places.needsUpdate = this.colors.needsUpdate = true;
  }

  #write(i, at, chosen) {
    const {floats, words} = this;
    point.fromArray(floats, at + AT.point);
    normal.fromArray(floats, at + AT.normal);
    axis.fromArray(floats, at + AT.axis);
    const straight = axis.lengthSq() > 0.5;
    across.set(Math.abs(normal.x) < 0.7 ? 1 : 0, Math.abs(normal.x) < 0.7 ? 0 : 1, 0);
    if (straight) along.copy(axis);
    else along.crossVectors(normal, across).normalize();
    across.crossVectors(along, normal);
    const radius = Math.min(floats[at + AT.radius], floats[at + AT.reach], SHARE * this.size);
    const touching = words[at + AT.flags] & 1;
    const opacity = (touching ? 0.55 : 0.25) * (words[at + AT.hand] === chosen ? 1 : 0.5);
    for (let corner = 0; corner < CORNERS; ++corner) {
      const ring = Math.ceil(corner / AROUND);
      const angle = (2 * Math.PI * corner) / AROUND;
      const [u, v] = [(radius * ring * Math.cos(angle)) / RINGS, (radius * ring * Math.sin(angle)) / RINGS];
      const bend = (floats[at + AT.curvature] * (straight ? v * v : u * u + v * v)) / 2;
      place.copy(point).addScaledVector(along, u).addScaledVector(across, v).addScaledVector(normal, -bend);
      place.toArray(this.places.array, 3 * (i * CORNERS + corner));
      this.colors.array.set([1, 1, 1, opacity], 4 * (i * CORNERS + corner));
    }
  }
}

/** Triangles of a center and rings around it, for each of many patches. */
function cornersOf(patches) {
  const corners = [];
  for (let i = 0; i < patches; ++i) {
    const first = i * CORNERS;
    const on = (ring, step) => (ring === 0 ? first : first + 1 + (ring - 1) * AROUND + (step % AROUND));
    for (let step = 0; step < AROUND; ++step) {
      corners.push(first, on(1, step), on(1, step + 1));
      for (let ring = 1; ring < RINGS; ++ring) {
        corners.push(on(ring, step), on(ring + 1, step), on(ring + 1, step + 1), on(ring, step), on(ring + 1, step + 1), on(ring, step + 1));
      }
    }
  }
  return corners;
}
