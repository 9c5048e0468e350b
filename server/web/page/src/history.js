// The recent past of one hand, for the plots.

const SECONDS = 60;
const RATE = 60;  // [Hz] most pictures a second
const KEPT = SECONDS * RATE;
const GAP = 1;  // [s] without a picture from which a line has a gap

/** Columns of numbers that grow at the end and forget at the beginning. Appending allocates nothing. */
export class History {
  /** @param {number} columns values an entry has beside its time */
  constructor(columns) {
    this.size = 0;
    this.columns = Array.from({length: columns + 1}, () => new Float64Array(2 * KEPT));
    this.unknown = new Array(columns).fill(NaN);
  }

  /** @param {number} time [s] @param {number[]} values one for each column */
  add(time, values) {
    const last = this.end;
    if (this.size > 0 && time <= last) {
      if (time === last) return;
      this.size = 0;  // Another server, or one that began anew.
    }
    if (this.size > 0 && time - last > GAP) this.#append((last + time) / 2, this.unknown);
    this.#append(time, values);
  }

  /** Time [s] of the newest entry; 0: there is none. */
  get end() {
    return this.size > 0 ? this.columns[0][this.size - 1] : 0;
  }

  /** @param {number} time [s] @returns {number} the first entry that is not before it; `size`: there is none */
  at(time) {
    const times = this.columns[0];
    let low = 0;
    let high = this.size;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] < time) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  #append(time, values) {
    if (this.size === 2 * KEPT) {
      for (const column of this.columns) column.copyWithin(0, KEPT);
      this.size = KEPT;
    }
    this.columns[0][this.size] = time;
    for (let i = 0; i < values.length; ++i) this.columns[i + 1][this.size] = values[i];
    this.size += 1;
  }
}
