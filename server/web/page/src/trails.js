// The ways of all hands, in one draw call: each is as long in time as any other, and fades with its age.

import {BufferAttribute, BufferGeometry, DynamicDrawUsage, LineBasicMaterial, LineSegments} from 'three';

const POINTS = 180;  // of a trail
const WORDS = 3 * POINTS;

export class Trails {
  constructor() {
    this.places = new Map();  // number of a hand -> its place among the trails; the places in use are the first ones
    this.seen = new Set();
    this.mesh = new LineSegments(new BufferGeometry(), new LineBasicMaterial({vertexColors: true, transparent: true, depthWrite: false}));
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 2;
    this.#grow(16);
  }

  /** @param {{muted: string}} colors of the theme */
  paint(colors) {
    this.mesh.material.color.set(colors.muted);
  }

  get shown() {
    return this.mesh.material.visible;
  }

  set shown(shown) {
    this.mesh.material.visible = shown;
  }

  /** Adds the place of each hand of a picture, and forgets the hands that left. @param {(i: number) => {number: number, floats: Float32Array, at: number}} hand */
  add(count, hand) {
    this.seen.clear();
    for (let i = 0; i < count; ++i) {
      const {number, floats, at} = hand(i);
      this.seen.add(number);
      const first = WORDS * (this.places.get(number) ?? this.#begin(number, floats, at));
      this.array.copyWithin(first, first + 3, first + WORDS);
      for (let axis = 0; axis < 3; ++axis) this.array[first + WORDS - 3 + axis] = floats[at + axis];
    }
    for (const number of this.places.keys()) if (!this.seen.has(number)) this.#end(number);
    this.#changed();
  }

  /** Draws a way instead, until the next picture. @param {number} number of a hand @param {number[]} way x, y, z of each place, the oldest first */
  set(number, way) {
    const place = this.places.get(number);
    if (place === undefined || way.length < 3) return;
    const kept = way.slice(-WORDS);
    for (let i = 0; i < POINTS - kept.length / 3; ++i) this.array.set(kept.slice(0, 3), WORDS * place + 3 * i);
    this.array.set(kept, WORDS * (place + 1) - kept.length);
    this.#changed();
  }

  clear() {
    this.places.clear();
    this.#changed();
  }

  /** Lengths of all trails [m], as drawn. */
  lengths() {
    return [...this.places.values()].map((place) => {
      const way = this.array.subarray(WORDS * place, WORDS * (place + 1));
      let sum = 0;
      for (let i = 3; i < WORDS; i += 3) sum += Math.hypot(way[i] - way[i - 3], way[i + 1] - way[i - 2], way[i + 2] - way[i - 1]);
      return sum;
    });
  }

  #begin(number, floats, at) {
    const place = this.places.size;
    if (WORDS * (place + 1) > this.array.length) this.#grow(2 * place);
    for (let i = 0; i < POINTS; ++i) for (let axis = 0; axis < 3; ++axis) this.array[WORDS * place + 3 * i + axis] = floats[at + axis];
    this.places.set(number, place);
    return place;
  }

  /** The last trail takes the place of the one that ends. */
  #end(number) {
    const place = this.places.get(number);
    this.places.delete(number);
    const last = this.places.size;
    if (place === last) return;
    this.array.copyWithin(WORDS * place, WORDS * last, WORDS * (last + 1));
    for (const [other, at] of this.places) if (at === last) this.places.set(other, place);
  }

  #changed() {
    const {geometry} = this.mesh;
    const {position} = geometry.attributes;
    geometry.setDrawRange(0, 2 * (POINTS - 1) * this.places.size);
    this.mesh.visible = this.places.size > 0;
    position.clearUpdateRanges();
    position.addUpdateRange(0, WORDS * this.places.size);
    position.needsUpdate = true;
  }

  #grow(capacity) {
    const places = new Float32Array(WORDS * capacity);
    const colors = new Float32Array(4 * POINTS * capacity);
    const ends = new Uint32Array(2 * (POINTS - 1) * capacity);
    if (this.array) places.set(this.array);
    for (let i = 0; i < POINTS * capacity; ++i) colors.set([1, 1, 1, 0.8 * ((i % POINTS) / POINTS) ** 1.5], 4 * i);
    for (let i = 0; i < (POINTS - 1) * capacity; ++i) {
      const from = i + Math.floor(i / (POINTS - 1));
      ends.set([from, from + 1], 2 * i);
    }
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(places, 3).setUsage(DynamicDrawUsage));
    geometry.setAttribute('color', new BufferAttribute(colors, 4));
    geometry.setIndex(new BufferAttribute(ends, 1));
    this.mesh.geometry.dispose();
    this.mesh.geometry = geometry;
    this.array = places;
  }
}
