// The recent past of one hand, for the plots.

const SECONDS = 60;
const RATE = 60;  // [Hz] most pictures a second
const KEPT = SECONDS * RATE;

/** Columns of numbers that grow at the end and forget at the beginning. Appending allocates nothing. */
export class History {
  /** @param {number} columns values an entry has beside its time */
  constructor(columns) {
    this.size = 0;
    this.columns = Array.from({length: columns + 1}, () => new Float64Array(2 * KEPT));
  }

  /** @param {number} time [s] @param {number[]} values one for each column */
  add(time, values) {
    if (this.size > 0 && time <= this.columns[0][this.size - 1]) {
      if (time === this.columns[0][this.size - 1]) return;
      this.size = 0;  // Another server, or one that began anew.
    }
    if (this.size === 2 * KEPT) {
      for (const column of this.columns) column.copyWithin(0, KEPT);
      this.size = KEPT;
    }
    this.columns[0][this.size] = time;
    for (let i = 0; i < values.length; ++i) this.columns[i + 1][this.size] = values[i];
    this.size += 1;
  }

  /** @param {number} seconds @returns {number} the first entry of the last `seconds` */
  since(seconds) {
    const times = this.columns[0];
    let low = 0;
    let high = this.size;
    const from = this.size > 0 ? times[this.size - 1] - seconds : 0;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (times[middle] < from) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
