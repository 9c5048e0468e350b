// A whole recording at a glance: the largest forces and the reasons in each part of its time. Chunks are read one after the other
// while nothing else is to be done.

import {length3} from '../messages.js';
import {ACCOUNT, askedForce, ROW} from './tables.js';
import {classOf, CLASSES} from './reasons.js';

const PARTS = 1000;  // at most
const MARKS = 1000;  // at most
const PER_SECOND = 40;  // a part is longer than the time between two pictures

export class Overview {
  /** @param {import('./recording.js').Recording} recording */
  constructor(recording) {
    this.recording = recording;
    this.parts = Math.min(PARTS, Math.max(10, Math.round(PER_SECOND * recording.duration)));
    this.held = new Float32Array(this.parts).fill(NaN);  // [N] the largest in each part; NaN: not read yet, or nothing there
    this.asked = new Float32Array(this.parts).fill(NaN);
    this.classes = new Uint32Array(this.parts * CLASSES.length);  // ticks of each class
    this.reasons = new Map();  // number -> ticks
    this.most = 0;  // [N]
    this.way = new Float32Array(3 * this.parts).fill(NaN);  // [m] where the first hand was in each part
    this.low = [Infinity, Infinity, Infinity];  // [m] where hands were
    this.high = [-Infinity, -Infinity, -Infinity];
    this.hands = new Set();  // numbers of /scene/picture
    this.ownHand = false;
    this.marks = recording.marks.slice(0, MARKS);  // {time, text}
    this.done = 0;  // chunks
    this.stopped = false;
  }

  partOf(time) {
    return Math.min(this.parts - 1, Math.max(0, Math.floor((time / Math.max(this.recording.duration, 1e-9)) * this.parts)));
  }

  /** Reads the whole recording. Calls `news` a few times a second, and at the end. */
  async run(news) {
    const {chunks} = this.recording;
    // First some that lie far apart, so that the view fits soon.
    const step = Math.max(1, Math.ceil(chunks.length / 8));
    const order = [...chunks.filter((_, i) => i % step === 0), ...chunks.filter((_, i) => i % step !== 0)];
    let said = 0;
    for (const chunk of order) {
      const segment = await this.recording.read(chunk);
      if (this.stopped) return;
      if (segment) this.#take(segment);
      this.done += 1;
      if (performance.now() - said > 250 || this.done === chunks.length) {
        said = performance.now();
        news();
        await new Promise((resolve) => setTimeout(resolve));  // The page goes first.
      }
    }
  }

  stop() {
    this.stopped = true;
  }

  #take(segment) {
    const {own, accounts, watches} = segment;
    this.marks.push(...segment.marks.slice(0, MARKS - this.marks.length));
    this.marks.sort((a, b) => a.time - b.time);
    for (let i = 0; i < accounts.count; ++i) {
      const row = i * ACCOUNT.size;
      const reason = accounts.rows[row + ACCOUNT.reason];
      this.reasons.set(reason, (this.reasons.get(reason) ?? 0) + 1);
      this.classes[this.partOf(accounts.times[i]) * CLASSES.length + classOf(reason, accounts.rows[row + ACCOUNT.cut])] += 1;
    }
    if (own.count > 0 && !watches) {
      this.ownHand = true;
      this.#takeForces(own, true);
    }
    for (const [number, table] of segment.hands) {
      this.hands.add(number);
      this.#takeForces(table, !this.ownHand && number === Math.min(...this.hands));
    }
  }

  /** @param {boolean} first whether it is the hand whose way is drawn */
  #takeForces({count, times, rows}, first) {
    for (let i = 0; i < count; ++i) {
      const row = i * ROW.size;
      const part = this.partOf(times[i]);
      const held = length3(rows, row + ROW.held);
      const asked = askedForce(rows, row);
      if (!(held <= this.held[part])) this.held[part] = held;
      if (asked >= 0 && !(asked <= this.asked[part])) this.asked[part] = asked;
      this.most = Math.max(this.most, held, asked >= 0 ? asked : 0);
      for (let axis = 0; axis < 3; ++axis) {
        this.low[axis] = Math.min(this.low[axis], rows[row + axis]);
        this.high[axis] = Math.max(this.high[axis], rows[row + axis]);
      }
      if (first && Number.isNaN(this.way[3 * part])) this.way.set(rows.subarray(row, row + 3), 3 * part);
    }
  }
}
