// Protobuf, as far as recordings need it: a message is walked field by field, without a schema. What does not fit throws a RangeError.

import {say} from '../language.js';

/** Walks the fields of a message. @example for (const fields = new Fields(bytes); fields.next();) ... fields.number */
export class Fields {
  /** @param {DataView} view @param {number} at where the message begins @param {number} end where it ends */
  constructor(view, at, end) {
    if (end > view.byteLength) throw new RangeError(say('file.range.message'));
    this.view = view;
    this.at = at;
    this.limit = end;
    this.number = 0;  // of the field
    this.type = 0;
    this.begin = 0;  // of a field of bytes
    this.end = 0;
    this.value = 0;  // of any other
  }

  /** @returns {boolean} whether there is another field */
  next() {
    if (this.at >= this.limit) return false;
    const tag = this.#varint();
    this.number = tag >>> 3;
    this.type = tag & 7;
    switch (this.type) {
      case 0:
        this.value = this.#varint();
        break;
      case 1:
        this.value = this.view.getFloat64(this.at, true);
        this.at += 8;
        break;
      case 2:
        this.end = this.#varint();
        this.begin = this.at;
        this.at = this.end += this.begin;
        break;
      case 5:
        this.value = this.view.getUint32(this.at, true);
        this.at += 4;
        break;
      default:
        throw new RangeError(say('file.range.kind'));
    }
    if (this.at > this.limit) throw new RangeError(say('file.range.field'));
    return true;
  }

  /** The field as a message of its own. */
  message() {
    if (this.type !== 2) throw new RangeError(say('file.range.nested'));
    return new Fields(this.view, this.begin, this.end);
  }

  text() {
    return new TextDecoder().decode(new Uint8Array(this.view.buffer, this.view.byteOffset + this.begin, this.end - this.begin));
  }

  /** Puts fields 1 to count, which are doubles, into `out`. Those that are absent are zero. */
  numbers(out, at, count) {
    for (let i = 0; i < count; ++i) out[at + i] = 0;
    const parts = this.message();
    while (parts.next()) if (parts.type === 1 && parts.number <= count) out[at + parts.number - 1] = parts.value;
  }

  /** A number beyond 2^53 is rounded. */
  #varint() {
    let value = 0;
    for (let factor = 1, i = 0; i < 10; ++i, factor *= 128) {
      const byte = this.view.getUint8(this.at++);
      value += (byte & 127) * factor;
      if (byte < 128) return value;
    }
    throw new RangeError(say('file.range.number'));
  }
}
