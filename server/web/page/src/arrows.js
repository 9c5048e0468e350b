// Force arrows: one kind of force has one colour and one width.

import {ConeGeometry, CylinderGeometry, MeshBasicMaterial, Vector3} from 'three';
import {Pool} from './pool.js';

const shaft = new CylinderGeometry(1, 1, 1, 12).translate(0, 0.5, 0).rotateX(Math.PI / 2);
const head = new ConeGeometry(1, 1, 16).translate(0, 0.5, 0).rotateX(Math.PI / 2);
const part = new Vector3();
const neck = new Vector3();

/** Unit cylinder along z, from 0 to 1. */
export {shaft as rodShape};

/** Arrows of one kind of force. They are seen through objects: a force inside a body matters most. */
export class Arrows {
  /**
   * @param {import('three').Object3D} parent
   * @param {{width: number, opacity: number, order: number}} look width of the shaft in pixels
   */
  constructor(parent, look) {
    this.width = look.width;
    this.material = new MeshBasicMaterial({transparent: true, opacity: look.opacity, depthTest: false, depthWrite: false});
    this.shafts = new Pool(shaft, this.material, parent, look.order);
    this.heads = new Pool(head, this.material, parent, look.order);
  }

  clear() {
    this.shafts.clear();
    this.heads.clear();
  }

  /**
   * @param {Vector3} from where the arrow begins
   * @param {Vector3} vector its length and direction in the world
   * @param {number} pixel size of a pixel in the world
   */
  add(from, vector, pixel) {
    const length = vector.length();
    if (length < 0.5 * pixel) return;
    const tip = Math.min((8 + 2 * this.width) * pixel, 0.6 * length);
    const radius = 0.5 * this.width * pixel;
    part.copy(vector).multiplyScalar((length - tip) / length);
    this.shafts.addAlong(from, part, radius);
    neck.copy(from).add(part);
    part.copy(vector).multiplyScalar(tip / length);
    this.heads.addAlong(neck, part, Math.max(0.45 * tip, 1.2 * radius));
  }

  done() {
    this.shafts.done();
    this.heads.done();
  }
}
