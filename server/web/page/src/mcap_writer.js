// Writes an MCAP file (mcap.dev/spec) into memory, in chunks that are not compressed.

import {crc32} from './replay/bytes.js';

const MAGIC = Uint8Array.of(0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a);
const OP = {header: 1, footer: 2, schema: 3, channel: 4, message: 5, chunk: 6, messageIndex: 7, chunkIndex: 8, statistics: 11, metadata: 12, metadataIndex: 13, dataEnd: 15};
const HEAD = 9;  // [bytes] opcode and length of a record
const CHUNK_BYTES = 1 << 18;
const CHUNK_TIME = 1_000_000_000n;  // [ns]
const encoder = new TextEncoder();

/** Bytes that grow; numbers are little-endian. */
class Bytes {
  constructor() {
    this.size = 0;
    this.#room(256);
  }

  u8(value) {
    const at = this.#grow(1);
    this.view.setUint8(at, value);
    return this;
  }

  u16(value) {
    const at = this.#grow(2);
    this.view.setUint16(at, value, true);
    return this;
  }

  u32(value) {
    const at = this.#grow(4);
    this.view.setUint32(at, value, true);
    return this;
  }

  /** @param {number | bigint} value */
  u64(value) {
    const at = this.#grow(8);
    this.view.setBigUint64(at, BigInt(value), true);
    return this;
  }

  /** @param {Uint8Array} data */
  bytes(data) {
    const at = this.#grow(data.length);
    this.array.set(data, at);
    return this;
  }

  /** @param {Uint8Array} data after its length */
  block(data) {
    return this.u32(data.length).bytes(data);
  }

  text(text) {
    return this.block(encoder.encode(text));
  }

  get all() {
    return this.array.subarray(0, this.size);
  }

  /** Makes room. @returns {number} where it begins */
  #grow(count) {
    const at = this.size;
    if (at + count > this.array.length) this.#room(Math.max(2 * this.array.length, at + count));
    this.size += count;
    return at;
  }

  #room(size) {
    const larger = new Uint8Array(size);
    if (this.array) larger.set(this.array);
    this.array = larger;
    this.view = new DataView(larger.buffer);
  }
}

/** The order: schemas, channels and metadata, then messages, then finish(). */
export class McapWriter {
  /** @param {string} library that writes */
  constructor(library) {
    this.parts = [MAGIC];
    this.size = MAGIC.length;
    this.crc = crc32(MAGIC);
    this.schemas = [];  // records, which the summary repeats
    this.channels = [];  // {record, index, count}
    this.metadata = [];  // records of their index
    this.chunks = [];
    this.chunk = new Bytes();
    this.chunkTimes = null;  // [first, last] [ns]
    this.times = null;  // of all messages
    this.#record(OP.header, new Bytes().text('').text(library));
  }

  /** @param {Uint8Array} data @returns {number} its id */
  addSchema(name, encoding, data) {
    const id = this.schemas.length + 1;
    const record = new Bytes().u16(id).text(name).text(encoding).block(data);
    this.schemas.push(record);
    this.#record(OP.schema, record);
    return id;
  }

  /** @param {number} schema its id @returns {number} the channel's id */
  addChannel(schema, topic, encoding) {
    const id = this.channels.length + 1;
    const record = new Bytes().u16(id).u16(schema).text(topic).text(encoding).u32(0);
    this.channels.push({record, index: new Bytes(), count: 0});
    this.#record(OP.channel, record);
    return id;
  }

  /** @param {Object<string, string>} values */
  addMetadata(name, values) {
    const map = new Bytes();
    for (const [key, value] of Object.entries(values)) map.text(key).text(value);
    const [at, record] = [this.size, new Bytes().text(name).block(map.all)];
    this.#record(OP.metadata, record);
    this.metadata.push(new Bytes().u64(at).u64(HEAD + record.size).text(name));
  }

  /** @param {number} channel its id @param {bigint} time [ns] @param {Uint8Array} data */
  write(channel, time, data) {
    const [first, last] = widened(this.chunkTimes, time);
    if (this.chunk.size > 0 && (this.chunk.size + data.length > CHUNK_BYTES || last - first > CHUNK_TIME)) this.#endChunk();
    this.chunkTimes = widened(this.chunkTimes, time);
    this.times = widened(this.times, time);
    const {index, count} = this.channels[channel - 1];
    index.u64(time).u64(this.chunk.size);
    this.chunk.u8(OP.message).u64(22 + data.length).u16(channel).u32(count).u64(time).u64(time).bytes(data);
    this.channels[channel - 1].count += 1;
  }

  /** @returns {Uint8Array[]} the file, in parts */
  finish() {
    this.#endChunk();
    this.#record(OP.dataEnd, new Bytes().u32(this.crc));
    const start = this.size;
    this.crc = 0;
    for (const record of this.schemas) this.#record(OP.schema, record);
    for (const {record} of this.channels) this.#record(OP.channel, record);
    const counts = new Bytes();
    this.channels.forEach(({count}, i) => counts.u16(i + 1).u64(count));
    const [first, last] = this.times ?? [0n, 0n];
    this.#record(OP.statistics, new Bytes().u64(this.channels.reduce((sum, {count}) => sum + count, 0)).u16(this.schemas.length).u32(this.channels.length)
      .u32(0).u32(this.metadata.length).u32(this.chunks.length).u64(first).u64(last).block(counts.all));
    for (const record of this.chunks) this.#record(OP.chunkIndex, record);
    for (const record of this.metadata) this.#record(OP.metadataIndex, record);
    const end = new Bytes().u8(OP.footer).u64(20).u64(start).u64(0);
    end.u32(crc32(end.all, this.crc));  // of the summary, up to here
    this.parts.push(end.all, MAGIC);
    return this.parts;
  }

  #record(opcode, content) {
    const record = new Bytes().u8(opcode).u64(content.size).bytes(content.all);
    this.parts.push(record.all);
    this.crc = crc32(record.all, this.crc);
    this.size += record.size;
  }

  #endChunk() {
    if (this.chunk.size === 0) return;
    const records = this.chunk.all;
    const [from, to] = this.chunkTimes;
    const at = this.size;
    this.#record(OP.chunk, new Bytes().u64(from).u64(to).u64(records.length).u32(crc32(records)).text('').u64(records.length).bytes(records));
    const indexesAt = this.size;
    const places = new Bytes();
    this.channels.forEach((channel, i) => {
      if (channel.index.size === 0) return;
      places.u16(i + 1).u64(this.size);
      this.#record(OP.messageIndex, new Bytes().u16(i + 1).block(channel.index.all));
      channel.index = new Bytes();
    });
    this.chunks.push(new Bytes().u64(from).u64(to).u64(at).u64(indexesAt - at).block(places.all).u64(this.size - indexesAt).text('').u64(records.length).u64(records.length));
    this.chunk = new Bytes();
    this.chunkTimes = null;
  }
}

/** @param {[bigint, bigint] | null} times @param {bigint} time @returns {[bigint, bigint]} that have it, too */
function widened(times, time) {
  if (times === null) return [time, time];
  return [time < times[0] ? time : times[0], time > times[1] ? time : times[1]];
}
