// A recording that is open: which chunks are needed is read, the newest used are kept, and damaged ones are said once.

import {say} from '../language.js';
import {McapFile, RecordingError} from './mcap.js';
import {sceneOf, trianglesOf} from './scene_of_file.js';
import {readSegment} from './tables.js';

const KEPT = 96 * 2 ** 20;  // [bytes] of segments
const AT_ONCE = 4;  // chunks that are being read

export class Recording {
  /** Throws a RecordingError. @param {File} file @param {() => void} changed something that is shown has been read */
  static async open(file, changed) {
    const mcap = await McapFile.open(file);
    if (mcap.chunks.length === 0) {
      if (mcap.troubles.length > 0) throw new Error(mcap.troubles.join('\n'));
      mcap.fail(mcap.cutAt ?? 0, say('file.empty'), say('file.empty.remedy'));
    }
    return new Recording(mcap, changed);
  }

  constructor(mcap, changed) {
    this.mcap = mcap;
    this.changed = changed;
    this.name = mcap.file.name;
    this.about = mcap.about;
    this.scene = mcap.scene && sceneOf(mcap.scene);  // null: it is not in the file
    this.triangles = [];  // of its objects, once they have been read
    this.start = mcap.chunks[0].from;
    const end = mcap.chunks.reduce((last, {to}) => (to > last ? to : last), this.start);
    this.duration = Number(end - this.start) / 1e9;
    this.chunks = mcap.chunks.map((chunk) => ({
      ...chunk, begin: Number(chunk.from - this.start) / 1e9, end: Number(chunk.to - this.start) / 1e9, segment: null, failed: false, reading: null, shown: false,
    }));
    this.marks = mcap.marks.map(({time, text}) => ({time: Number(time - this.start) / 1e9, text}));  // of the program that recorded
    this.troubles = [...mcap.troubles];
    if (mcap.cutAt !== null) {
      this.troubles.push(say('file.cut', {file: this.name, at: mcap.cutAt}));
    }
    this.clock = 0;
    this.kept = 0;
    this.reading = 0;
  }

  /** Chunks that have messages between two times. */
  between(from, to) {
    return this.chunks.filter((chunk) => chunk.begin <= to && chunk.end >= from);
  }

  /** @returns {Promise<number>} [s] when the first hand is there; 0: there is none. Reads chunks from the beginning until then. */
  async begin() {
    for (const chunk of this.chunks) {
      const segment = await this.read(chunk);
      const times = segment ? segment.handTables().filter(({count}) => count > 0).map(({times: [first]}) => first) : [];
      if (times.length > 0) return Math.min(...times);
    }
    return 0;
  }

  /**
   * Segments between two times, of those chunks that have been read; the others are asked for.
   * @param {number} from [s] @param {number} to [s] @returns {{segments: import('./tables.js').Segment[], whole: boolean}}
   */
  segments(from, to) {
    const wanted = this.between(from, to);
    for (const chunk of wanted) chunk.shown = true;
    for (const chunk of wanted) if (!chunk.segment && !chunk.failed && !chunk.reading && this.reading < AT_ONCE) this.read(chunk);
    const there = wanted.filter((chunk) => chunk.segment);
    for (const {segment} of there) segment.used = ++this.clock;
    return {segments: there.map(({segment}) => segment), whole: wanted.every((chunk) => chunk.segment || chunk.failed)};
  }

  /** Reads a chunk. @returns {Promise<import('./tables.js').Segment | null>} null: it is damaged, and `troubles` say how */
  read(chunk) {
    if (chunk.segment || chunk.failed) return Promise.resolve(chunk.segment);
    this.reading += chunk.reading ? 0 : 1;
    chunk.reading ??= this.#read(chunk).finally(() => {
      chunk.reading = null;
      this.reading -= 1;
      if (chunk.shown) this.changed();  // What only the overview reads changes no picture.
      chunk.shown = false;
    });
    return chunk.reading;
  }

  async #read(chunk) {
    try {
      const segment = readSegment(await this.mcap.read(chunk), this.mcap, this.start);
      segment.used = ++this.clock;
      if (segment.geometry && this.scene) this.triangles = trianglesOf(segment.geometry, this.scene);
      chunk.segment = segment;
      this.kept += segment.bytes;
      this.#forget();
      return segment;
    } catch (error) {
      chunk.failed = true;
      if (error instanceof RecordingError) this.troubles.push(error.message);
      else if (error instanceof RangeError) {
        this.troubles.push(new RecordingError(this.name, chunk.at, say('file.message', {error: error.message})).message);
      } else throw error;
      return null;
    }
  }

  /** Lets go of the segments that were not used for longest. */
  #forget() {
    if (this.kept <= KEPT) return;
    const there = this.chunks.filter((chunk) => chunk.segment).sort((a, b) => a.segment.used - b.segment.used);
    for (const chunk of there) {
      if (this.kept <= KEPT / 2 || chunk.segment.used === this.clock) return;
      this.kept -= chunk.segment.bytes;
      chunk.segment = null;
    }
  }
}

/** The last row of a table that is not later than a time. @returns {{table: import('./tables.js').Table, row: number, time: number} | null} */
export function rowAt(segments, tableOf, time) {
  let best = null;
  for (const segment of segments) {
    const table = tableOf(segment);
    const index = table ? table.before(time) : -1;
    if (index >= 0 && (!best || table.times[index] >= best.time)) best = {table, row: index * table.width, time: table.times[index]};
  }
  return best;
}
