// Little-endian numbers out of bytes that somebody else wrote, and their CRC.

import {say} from '../language.js';

const TABLE = Uint32Array.from({length: 256}, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; ++bit) value = value & 1 ? 0xedb88320 ^ (value >>> 1) : value >>> 1;
  return value;
});

/** CRC-32 as zlib has it. @param {Uint8Array} bytes @param {number} before CRC of what came before */
export function crc32(bytes, before = 0) {
  let value = ~before;
  for (let i = 0; i < bytes.length; ++i) value = TABLE[(value ^ bytes[i]) & 255] ^ (value >>> 8);
  return ~value >>> 0;
}

/** Reads one value after the other. Past the end every read throws a RangeError. */
export class Cursor {
  /** @param {Uint8Array} bytes */
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }

  get left() {
    return this.bytes.length - this.at;
  }

  u8() {
    return this.view.getUint8((this.at += 1) - 1);
  }

  u16() {
    return this.view.getUint16((this.at += 2) - 2, true);
  }

  u32() {
    return this.view.getUint32((this.at += 4) - 4, true);
  }

  /** A length or a place. One beyond 2^53 is rounded, and is too large in any case. */
  u64() {
    const low = this.u32();
    return low + 2 ** 32 * this.u32();
  }

  /** A time in nanoseconds. @returns {bigint} */
  time() {
    return this.view.getBigUint64((this.at += 8) - 8, true);
  }

  /** @param {number} size */
  take(size) {
    if (!(size <= this.left)) throw new RangeError(say('file.range.end'));
    return this.bytes.subarray(this.at, (this.at += size));
  }

  text() {
    return new TextDecoder().decode(this.take(this.u32()));
  }

  /** @returns {Object<string, string>} */
  map() {
    const entries = new Cursor(this.take(this.u32()));
    const result = {};
    while (entries.left > 0) {
      const key = entries.text();
      result[key] = entries.text();
    }
    return result;
  }
}
