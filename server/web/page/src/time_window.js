// The part of time that plots show: the last seconds, or a part that the user has zoomed or moved to.

const LEAST = 0.1;  // [s]
const MOST = 120;

export class TimeWindow {
  constructor() {
    this.seconds = 10;  // before now
    this.fixed = null;  // [from, to] [s]; null: it ends now
  }

  /** @param {number} now [s] @returns {[number, number]} [s] */
  range(now) {
    return this.fixed ?? [now - this.seconds, now];
  }

  /** @param {number} factor above 1 shows less @param {number} at [s] what stays where it is @param {number} now [s] */
  zoom(factor, at, now) {
    const [from, to] = this.range(now);
    const size = Math.min(Math.max((to - from) / factor, LEAST), MOST);
    const share = (at - from) / (to - from);
    this.fixed = [at - share * size, at + (1 - share) * size];
  }

  /** @param {number} seconds later @param {number} now [s] */
  move(seconds, now) {
    this.fixed = this.range(now).map((time) => time + seconds);
  }

  /** It ends now again. */
  follow() {
    this.fixed = null;
  }
}
