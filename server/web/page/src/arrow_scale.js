// How long arrows are drawn: the strongest force of the last seconds takes a part of the view's height.

import {roundDown} from './words.js';

const WINDOW = 4;  // [s] two of these are remembered
const LEAST = 0.2;  // [N] weaker forces do not make arrows longer
/** Shares of the view's height. An arrow between the first two keeps its scale, so that scales are calm. */
const SHORTEST = 0.1;
const LONGEST = 0.4;
const WANTED = 0.3;

export class ArrowScale {
  constructor() {
    this.clear();
  }

  clear() {
    this.began = -Infinity;
    this.now = 0;  // [N] strongest in this window, and in the one before
    this.before = 0;
  }

  /**
   * Arrows become shorter at once, and longer at the end of a window.
   * @param {number} perNewton [m] as arrows are drawn now @param {number} strongest [N] of all forces now
   * @param {number} height [m] of what the view shows @param {number} time [s] of the picture
   * @returns {number} [m] for a newton
   */
  step(perNewton, strongest, height, time) {
    const ended = time < this.began || time - this.began > WINDOW;
    if (ended) [this.before, this.now, this.began] = [this.now, 0, time];
    this.now = Math.max(this.now, strongest);
    const peak = Math.max(this.now, this.before, LEAST);
    const share = (perNewton * peak) / height;
    return share > LONGEST || (ended && share < SHORTEST) ? roundDown((WANTED * height) / peak) : perNewton;
  }
}
