// The binary messages of feltwire.live.v1. All numbers are little-endian, as is every machine that runs a browser.

/** First byte of a binary message. */
export const KIND = {geometry: 1, picture: 2, surfaces: 3};

const HEADER_WORDS = 6;
const HAND_WORDS = 28;
const BODY_WORDS = 8;
const ROBOT_WORDS = 25;

/** Places of a hand's values in its record, in words of four bytes. Vectors have three words, the quaternion (w, x, y, z) four. */
export const AT = {
  number: 0, reasons: 1, position: 2, orientation: 5, proxy: 9, elastic: 12, friction: 15, rendered: 18,
  depth: 21, delivered: 22, burned: 23, room: 24, rate: 25, loss: 26, roundTrip: 27,
};

/** Places of a body's values in its record. */
export const BODY_AT = {index: 0, position: 1, orientation: 4};

/** Places of a robot's values in its record. */
export const ROBOT_AT = {state: 0, hand: 1, flags: 2, position: 3, orientation: 6, target: 10, targetTurn: 13, force: 17, torque: 20, gripper: 23, age: 24};

/**
 * Reads the geometry of one object.
 * @param {ArrayBuffer} buffer a whole message of kind 1
 * @returns {{index: number, version: number, positions: Float32Array, corners: Uint32Array} | null} null if it is malformed
 */
export function readGeometry(buffer) {
  if (buffer.byteLength < 20) return null;
  const [, index, version, vertices, triangles] = new Uint32Array(buffer, 0, 5);
  if (buffer.byteLength < 20 + 12 * (vertices + triangles)) return null;
  const positions = new Float32Array(buffer, 20, 3 * vertices);
  const corners = new Uint32Array(buffer, 20 + 12 * vertices, 3 * triangles);
  for (const corner of corners) if (corner >= vertices) return null;
  return {index, version, positions, corners};
}

/** A picture: views of one message, without a copy. `floats` and `words` read the same bytes. */
export class Picture {
  hands = 0;
  bodies = 0;
  version = 0;
  time = 0;
  floats = new Float32Array(0);
  words = new Uint32Array(0);

  /**
   * @param {ArrayBuffer} buffer a whole message of kind 2
   * @returns {boolean} false if it is malformed; the picture is then as it was
   */
  read(buffer) {
    if (buffer.byteLength < 4 * HEADER_WORDS || buffer.byteLength % 4 !== 0) return false;
    const words = new Uint32Array(buffer);
    if (words.length < HEADER_WORDS + HAND_WORDS * words[1] + BODY_WORDS * words[2]) return false;
    this.words = words;
    this.floats = new Float32Array(buffer);
    this.hands = words[1];
    this.bodies = words[2];
    this.version = words[3];
    this.time = new DataView(buffer).getFloat64(16, true);
    return true;
  }

  /** @param {number} i @returns {number} where the record of hand i begins */
  handAt(i) {
    return HEADER_WORDS + HAND_WORDS * i;
  }

  /** @param {number} i @returns {number} where the record of body i begins */
  bodyAt(i) {
    return HEADER_WORDS + HAND_WORDS * this.hands + BODY_WORDS * i;
  }

  /** @returns {number[]} where the records of the robots begin */
  robotsAt() {
    const first = this.bodyAt(this.bodies);
    return Array.from({length: Math.floor((this.words.length - first) / ROBOT_WORDS)}, (_, i) => first + ROBOT_WORDS * i);
  }
}

/** Length of the vector that begins at `at`. */
export function length3(floats, at) {
  return Math.hypot(floats[at], floats[at + 1], floats[at + 2]);
}

export {HAND_WORDS};
