// The spring between the viewer's own hand and the place that it is pulled to.

import {Group, MeshBasicMaterial, Quaternion, SphereGeometry, Vector3} from 'three';
import {rodShape} from './arrows.js';
import {Pool} from './pool.js';

const COILS = 7;
const PARTS = 12;  // straight parts of a coil
const END = 0.12;  // share of the length that is straight, at each end
const RADIUS = 6;  // [pixels] of a coil
const up = new Vector3(0, 0, 1);
const side = new Vector3(1, 0, 0);
const [along, across, over, from, to] = Array.from({length: 5}, () => new Vector3());
const size = new Vector3();
const still = new Quaternion();

export class Spring {
  constructor() {
    this.group = new Group();
    this.material = new MeshBasicMaterial({transparent: true, depthTest: false, depthWrite: false});
    this.rods = new Pool(rodShape, this.material, this.group, 9);
    this.balls = new Pool(new SphereGeometry(1, 16, 12), this.material, this.group, 9);
  }

  /** @param {{ink: string}} colors of the theme */
  paint(colors) {
    this.material.color.set(colors.ink);
  }

  /**
   * @param {Vector3 | null} hand where it is drawn; null: not known yet
   * @param {Vector3 | null} target null: there is no spring
   * @param {number} pixel size of a pixel in the world
   */
  show(hand, target, pixel) {
    this.rods.clear();
    this.balls.clear();
    if (target) this.balls.add(target, still, size.setScalar(4.5 * pixel));
    if (target && hand && hand.distanceTo(target) > 2 * pixel) this.#coil(hand, target, pixel);
    this.rods.done();
    this.balls.done();
  }

  #coil(hand, target, pixel) {
    along.copy(target).sub(hand);
    across.crossVectors(along, Math.abs(along.z) > 0.9 * along.length() ? side : up).normalize();
    over.crossVectors(along, across).normalize();
    const radius = Math.min(RADIUS * pixel, 0.5 * along.length());
    const count = COILS * PARTS;
    const place = (i, result) => {
      const turn = (2 * Math.PI * i) / PARTS;
      const out = i === 0 || i === count ? 0 : radius;
      return result.copy(hand).addScaledVector(along, END + ((1 - 2 * END) * i) / count)
        .addScaledVector(across, out * Math.cos(turn)).addScaledVector(over, out * Math.sin(turn));
    };
    this.#rod(hand, place(0, to), pixel);
    for (let i = 0; i < count; ++i) this.#rod(place(i, from), place(i + 1, to), pixel);
    this.#rod(to, target, pixel);
  }

  #rod(begin, end, pixel) {
    this.rods.addAlong(begin, size.copy(end).sub(begin).clone(), 0.9 * pixel);
  }
}
