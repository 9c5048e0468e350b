// Opens an MCAP file (mcap.dev/spec) by its index, and reads one chunk at a time: a large file takes little memory. A file without
// an end is searched from its beginning, from one record's head to the next.

import {decompress} from 'fzstd';
import {say} from '../language.js';
import {crc32, Cursor} from './bytes.js';

const MAGIC = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
const OP = {header: 1, footer: 2, schema: 3, channel: 4, message: 5, chunk: 6, chunkIndex: 8, metadata: 12, metadataIndex: 13, dataEnd: 15};
const HEAD = 9;  // [bytes] opcode and length of a record
const FOOTER = HEAD + 20;
const PAGE = 1 << 15;  // [bytes] that are read at once while searching
const MOST = {record: 2 ** 28, chunk: 2 ** 26, summary: 2 ** 26};  // [bytes] that a file may ask for
const NAMED = new Map([['feltwire', 'about'], ['scene', 'scene']]);  // metadata records that are kept, and where
const MARK = 'mark';  // metadata records of moments that a program marked
const CONVERT = 'mcap compress --compression zstd';

/** What is wrong with a recording, where, and what to do. */
export class RecordingError extends Error {
  /** @param {string} name @param {number} at byte @param {string} what @param {string} remedy */
  constructor(name, at, what, remedy = say('file.copy')) {
    super(say('file.where', {file: name, at, what, remedy}));
  }
}

/** A chunk of messages: where it lies, and the times of its first and last message [ns]. */
function chunkOf(from, to, at, length, size) {
  return {from, to, at, length, size};
}

export class McapFile {
  /**
   * Throws a RecordingError if nothing of the file can be read.
   * @param {File} file @returns {Promise<McapFile>}
   */
  static async open(file) {
    const mcap = new McapFile(file);
    const begin = await mcap.slice(0, MAGIC.length);
    if (!begin.every((byte, i) => byte === MAGIC[i]) || begin.length === 0) {
      mcap.fail(0, say('file.none'), say('file.none.remedy'));
    }
    if (!(await mcap.#readSummary())) await mcap.#search();
    mcap.chunks.sort((a, b) => (a.from < b.from ? -1 : a.from > b.from ? 1 : 0));
    return mcap;
  }

  /** @param {File} file */
  constructor(file) {
    this.file = file;
    this.channels = new Map();  // id -> topic
    this.chunks = [];
    this.about = {};  // values of the metadata record "feltwire"
    this.scene = null;  // of the metadata record "scene"
    this.marks = [];  // {time, text} [ns since 1970] of the metadata records "mark"
    this.cutAt = null;  // byte at which a file without an end was cut
    this.troubles = [];  // sentences on what could not be read
  }

  fail(at, what, remedy) {
    throw new RecordingError(this.file.name, at, what, remedy);
  }

  /** @returns {Promise<Uint8Array>} shorter where the file ends */
  async slice(from, to) {
    try {
      return new Uint8Array(await this.file.slice(from, to).arrayBuffer());
    } catch (error) {
      return this.fail(from, say('file.unread', {error: error.message}), say('file.unread.remedy'));
    }
  }

  /**
   * The records of a chunk, decompressed and checked. Throws a RecordingError.
   * @param {{at: number, length: number, size: number}} chunk @returns {Promise<Uint8Array>}
   */
  async read(chunk) {
    const bytes = await this.slice(chunk.at, chunk.at + chunk.length);
    try {
      const cursor = new Cursor(bytes);
      if (cursor.u8() !== OP.chunk || cursor.u64() !== chunk.length - HEAD) this.fail(chunk.at, say('file.index'));
      cursor.take(16);  // its times
      const size = cursor.u64();
      const crc = cursor.u32();
      const compression = cursor.text();
      const stored = cursor.take(cursor.u64());
      if (size > MOST.chunk) this.fail(chunk.at, say('file.large', {size, most: MOST.chunk}));
      const records = this.#expand(chunk, compression, stored, size);
      if (crc !== 0 && crc !== crc32(records)) this.fail(chunk.at, say('file.crc'));
      return records;
    } catch (error) {
      if (error instanceof RangeError) this.fail(chunk.at, say('file.field'));
      throw error;
    }
  }

  #expand(chunk, compression, stored, size) {
    if (compression !== '' && compression !== 'zstd') this.fail(chunk.at, say('file.compression', {compression}), say('file.convert', {command: CONVERT}));
    let records = stored;
    if (compression === 'zstd') {
      try {
        records = decompress(stored, new Uint8Array(size));  // It never becomes larger than the room that is given.
      } catch {
        this.fail(chunk.at, say('file.unpacked'));
      }
    }
    if (records.length !== size) this.fail(chunk.at, say('file.size'));
    return records;
  }

  /** Takes the index at the end. @returns {Promise<boolean>} false if there is none that can be used */
  async #readSummary() {
    const {size} = this.file;
    const end = new Cursor(await this.slice(Math.max(0, size - FOOTER - MAGIC.length), size));
    if (end.left < FOOTER + MAGIC.length || !MAGIC.every((byte, i) => end.bytes[FOOTER + i] === byte) || end.u8() !== OP.footer) return false;
    end.u64();
    const start = end.u64();
    end.u64();
    const crc = end.u32();
    if (start === 0) return false;
    try {
      const length = size - MAGIC.length - start;
      if (!(length >= FOOTER && length <= MOST.summary)) this.fail(size - FOOTER - MAGIC.length, say('file.footer'));
      const bytes = await this.slice(start, start + length);
      if (crc !== 0 && crc !== crc32(bytes.subarray(0, length - 4))) this.fail(start, say('file.summary.crc'));
      await this.#takeSummary(bytes.subarray(0, length - FOOTER), start);
      return true;
    } catch (error) {
      if (!(error instanceof RecordingError || error instanceof RangeError)) throw error;
      this.troubles.push(error instanceof RangeError ? new RecordingError(this.file.name, start, say('file.summary.field')).message : error.message);
      [this.chunks, this.marks] = [[], []];
      return false;
    }
  }

  async #takeSummary(bytes, start) {
    const records = new Cursor(bytes);
    while (records.left > 0) {
      const at = start + records.at;
      const opcode = records.u8();
      const content = new Cursor(records.take(records.u64()));
      if (opcode === OP.channel) this.takeChannel(content);
      if (opcode === OP.chunkIndex) this.#takeChunkIndex(content, at);
      if (opcode === OP.metadataIndex) await this.#followMetadata(content, at);
    }
  }

  #takeChunkIndex(content, at) {
    const [from, to] = [content.time(), content.time()];
    const [place, length] = [content.u64(), content.u64()];
    content.take(content.u32());  // places of the message indexes
    content.u64();
    content.text();
    content.u64();
    const size = content.u64();
    if (place + length > this.file.size || length > MOST.record || size > MOST.chunk || to < from) this.fail(at, say('file.chunk.impossible'));
    this.chunks.push(chunkOf(from, to, place, length, size));
  }

  async #followMetadata(content, at) {
    const [place, length] = [content.u64(), content.u64()];
    const name = content.text();
    if (!NAMED.has(name) && name !== MARK) return;
    if (place + length > this.file.size || length > MOST.summary) this.fail(at, say('file.metadata.impossible'));
    const record = new Cursor(await this.slice(place, place + length));
    if (record.u8() !== OP.metadata) this.fail(place, say('file.metadata'));
    record.u64();
    this.#takeMetadata(record);
  }

  #takeMetadata(content) {
    const name = content.text();
    const member = NAMED.get(name);
    if (member) this[member] = content.map();
    if (name !== MARK) return;
    const {time, text} = content.map();
    if (text !== undefined && /^\d{1,19}$/.test(time)) this.marks.push({time: BigInt(time), text});
  }

  /** Also of channels that stand within a chunk. @param {Cursor} content */
  takeChannel(content) {
    const id = content.u16();
    content.u16();
    this.channels.set(id, content.text());
  }

  /** Goes from record to record until the file ends, or is damaged. */
  async #search() {
    let page = {at: 0, bytes: new Uint8Array(0)};
    const peek = async (at, size) => {
      if (at < page.at || at + size > page.at + page.bytes.length) page = {at, bytes: await this.slice(at, at + Math.max(size, PAGE))};
      return page.bytes.subarray(at - page.at, at - page.at + size);
    };
    const {size} = this.file;
    for (let at = MAGIC.length; ;) {
      const head = new Cursor(await peek(at, HEAD));
      if (head.left < HEAD) return this.#cut(at);
      const opcode = head.u8();
      const length = head.u64();
      if (opcode === 0 || length > MOST.record) return this.#damaged(at, say('file.record', {size: length, most: MOST.record}));
      if (at + HEAD + length > size) return this.#cut(at);
      try {
        if (opcode === OP.chunk) this.#findChunk(new Cursor(await peek(at + HEAD, Math.min(length, 64))), at, HEAD + length);
        if (opcode === OP.channel) this.takeChannel(new Cursor(await peek(at + HEAD, length)));
        if (opcode === OP.metadata) this.#takeMetadata(new Cursor(await peek(at + HEAD, length)));
      } catch (error) {
        if (!(error instanceof RangeError)) throw error;
        return this.#damaged(at, say('file.record.field'));
      }
      if (opcode === OP.message) return this.#damaged(at, say('file.loose'), say('file.convert', {command: CONVERT}));
      if (opcode === OP.footer || opcode === OP.dataEnd) return undefined;
      at += HEAD + length;
    }
  }

  #findChunk(content, at, length) {
    const [from, to] = [content.time(), content.time()];
    const size = content.u64();
    if (size > MOST.chunk || to < from) throw new RangeError(say('file.range.chunk'));
    this.chunks.push(chunkOf(from, to, at, length, size));
  }

  #cut(at) {
    this.cutAt = at;
  }

  #damaged(at, what, remedy) {
    this.troubles.push(new RecordingError(this.file.name, at, what, remedy).message);
  }
}
