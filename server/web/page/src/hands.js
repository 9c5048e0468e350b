// The page's data of every hand: the newest record, the recent past, and what has bounded its force.

import {History} from './history.js';
import {AT, HAND_WORDS, length3} from './messages.js';

/** Columns of a hand's history, after the time. */
export const COLUMN = {
  elastic: 1, friction: 2, commanded: 3, rendered: 4, depth: 5, given: 6, burned: 7, ceiling: 8, roundTrip: 9, loss: 10,
};

const FADE = 1.5;  // [s] over which the share of a reason is averaged
const NOW = 0.4;  // [s] for which a reason that just ended is still said, so that a flicker can be read

export class Hand {
  /** @param {number} number */
  constructor(number) {
    this.number = number;
    this.floats = new Float32Array(HAND_WORDS);
    this.reasons = 0;
    this.history = new History(Object.keys(COLUMN).length);
    this.share = new Float32Array(32);  // of the recent time, for each reason
    this.last = new Float64Array(32).fill(-Infinity);  // server time at which each reason was last given
    this.time = -Infinity;
    this.values = new Array(Object.keys(COLUMN).length).fill(0);
  }

  /** @param {Float32Array} floats @param {Uint32Array} words @param {number} at @param {number} time [s] */
  update(floats, words, at, time) {
    for (let i = 0; i < HAND_WORDS; ++i) this.floats[i] = floats[at + i];
    this.reasons = words[at + AT.reasons];
    const elapsed = time - this.time;
    const weight = elapsed > 0 && elapsed < Infinity ? 1 - Math.exp(-elapsed / FADE) : elapsed < 0 ? 1 : 0;
    for (let bit = 0; bit < 32; ++bit) {
      const on = (this.reasons >>> bit) & 1;
      this.share[bit] += weight * (on - this.share[bit]);
      if (on) this.last[bit] = time;
      else if (this.last[bit] > time) this.last[bit] = -Infinity;
    }
    this.time = time;
    const own = this.floats;
    const values = this.values;
    values[0] = this.elastic;
    values[1] = this.friction;
    values[2] = this.commanded;
    values[3] = this.rendered;
    values[4] = 1000 * own[AT.depth];
    values[5] = own[AT.delivered];
    values[6] = own[AT.burned];
    values[7] = own[AT.delivered] + own[AT.room];
    values[8] = 1000 * own[AT.roundTrip];
    values[9] = 100 * own[AT.loss];
    for (let i = 0; i < values.length; ++i) if (!Number.isFinite(values[i])) values[i] = NaN;  // A gap in the plot.
    this.history.add(time, values);
  }

  get elastic() {
    return length3(this.floats, AT.elastic);
  }

  get friction() {
    return length3(this.floats, AT.friction);
  }

  get rendered() {
    return length3(this.floats, AT.rendered);
  }

  /** Size of the sum of the elastic and the frictional force [N]. */
  get commanded() {
    const f = this.floats;
    const [e, r] = [AT.elastic, AT.friction];
    return Math.hypot(f[e] + f[r], f[e + 1] + f[r + 1], f[e + 2] + f[r + 2]);
  }

  /** Reasons that hold now or held a moment ago: their bits, the most frequent first. */
  activeReasons() {
    const bits = [];
    for (let bit = 0; bit < 32; ++bit) if (this.time - this.last[bit] < NOW) bits.push(bit);
    return bits.sort((a, b) => this.share[b] - this.share[a]);
  }
}

/** All hands of the scene that is watched. */
export class Hands {
  constructor() {
    this.all = new Map();
    this.changed = false;  // whether a hand came or left since the flag was cleared
  }

  /** @param {import('./messages.js').Picture} picture */
  update(picture) {
    for (let i = 0; i < picture.hands; ++i) {
      const at = picture.handAt(i);
      const number = picture.words[at + AT.number];
      let hand = this.all.get(number);
      if (!hand) {
        hand = new Hand(number);
        this.all.set(number, hand);
        this.changed = true;
      }
      hand.update(picture.floats, picture.words, at, picture.time);
    }
    if (this.all.size === picture.hands) return;
    for (const [number, hand] of this.all) {
      if (hand.time === picture.time) continue;
      this.all.delete(number);
      this.changed = true;
    }
  }

  clear() {
    this.all.clear();
    this.changed = true;
  }

  /** @returns {number[]} numbers of all hands, ascending */
  numbers() {
    return [...this.all.keys()].sort((a, b) => a - b);
  }
}
