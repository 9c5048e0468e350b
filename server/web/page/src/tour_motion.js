// The movement of the tour's hand, and what is measured of it.

import {AT, length3} from './messages.js';

const DOWN = 1;  // [s] in which it comes to the wall
const PRESS = 0.012;  // [m] below the wall that it is pulled to
const SLIDE = 0.03;  // [m] to each side
const TURNS = 0.5;  // [1/s]
const ASIDE = 0.06;  // [m] from the start of the scene, where other hands are
const NEAR = 6;  // samples before and after one, whose mean is no shaking
const LEAST = 0.2;  // [N] of a force that has a direction

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const along = (point, way, size) => point.map((value, axis) => value + size * way[axis]);

/** A direction along the wall: the axis that is farthest from its normal, without its part along the normal. */
function sideOf(normal) {
  const axis = normal.map(Math.abs).indexOf(Math.min(...normal.map(Math.abs)));
  const way = along([0, 1, 2].map((i) => Number(i === axis)), normal, -normal[axis]);
  const size = Math.sqrt(dot(way, way));
  return way.map((value) => value / size);
}

/** @param {{point: number[], normal: number[]}} wall @param {number[]} start [m] @param {number} time [s] since then @returns {number[]} [m] where the hand shall be */
export function pressAndSlide({point, normal}, start, time) {
  const height = dot(normal, along(start, point, -1));
  const way = sideOf(normal);
  const share = Math.min(time / DOWN, 1);
  const slide = ASIDE * share + SLIDE * Math.sin(2 * Math.PI * TURNS * Math.max(time - DOWN, 0));
  return along(along(start, normal, -share * (height + PRESS)), way, slide);
}

/** The samples of one hand in the last seconds: what the figure draws, and the row of the table. */
export class Trace {
  /** @param {number} seconds that are kept */
  constructor(seconds) {
    this.seconds = seconds;
    this.rows = [];  // {time, depth, shaking, asked, held, off, askedNormal, heldNormal, delivered}
  }

  get end() {
    return this.rows.at(-1)?.time ?? 0;
  }

  /** [s] between the first and the last sample. */
  get span() {
    return this.rows.length > 0 ? this.end - this.rows[0].time : 0;
  }

  /** @param {import('./hands.js').Hand} hand its newest picture, if it is new @param {{point: number[], normal: number[]}} wall */
  add(hand, {point, normal}) {
    const {floats, time} = hand;
    if (time <= this.end) return;
    const vector = (at) => [...floats.subarray(at, at + 3)];
    const [position, elastic, friction, held] = [AT.position, AT.elastic, AT.friction, AT.rendered].map(vector);
    const asked = along(elastic, friction, 1);
    const size = length3(floats, AT.rendered);
    const cosine = dot(asked, held) / (hand.commanded * size);
    const off = hand.commanded > LEAST && size > LEAST ? (Math.acos(Math.min(Math.max(cosine, -1), 1)) * 180) / Math.PI : NaN;
    this.rows.push({time, depth: -dot(normal, along(position, point, -1)), shaking: NaN, delivered: floats[AT.delivered], asked: hand.commanded, held: size, off, askedNormal: dot(asked, normal), heldNormal: dot(held, normal)});
    this.#shake(this.rows.length - 1 - NEAR);
    while (this.span > this.seconds) this.rows.shift();
  }

  /** The shaking of a row is its depth without the mean of the rows about it. */
  #shake(i) {
    if (i < NEAR) return;
    const around = this.rows.slice(i - NEAR, i + NEAR + 1);
    this.rows[i].shaking = this.rows[i].depth - around.reduce((sum, {depth}) => sum + depth, 0) / around.length;
  }

  clear() {
    this.rows = [];
  }

  /** @returns {Trace} which stays as it is */
  copy() {
    return Object.assign(new Trace(this.seconds), {rows: [...this.rows]});
  }

  /** @param {number} from [s] @returns {{shakes: number, depth: number, share: number, off: number}} [m], [m] at most, of what is asked, [deg]; NaN: it touched nothing */
  measured(from) {
    const rows = this.rows.filter(({time}) => time >= from);
    const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;
    const rest = rows.map(({shaking}) => shaking).filter((value) => !Number.isNaN(value));
    const touching = rows.filter(({asked}) => asked > LEAST);
    return {
      shakes: Math.sqrt(mean(rest.map((value) => value * value))), depth: Math.max(...rows.map(({depth}) => depth), 0),
      share: touching.length > 0 ? mean(touching.map(({held}) => held)) / mean(touching.map(({asked}) => asked)) : NaN,
      off: mean(rows.map(({off}) => off).filter((value) => !Number.isNaN(value))),
    };
  }
}
