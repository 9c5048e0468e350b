// The messages of one chunk as tables of numbers, a row for each tick or picture.

import {say} from '../language.js';
import {Cursor} from './bytes.js';
import {Fields} from './protobuf.js';
import {OBSERVER} from './reasons.js';

const MESSAGE = 5;
const CHANNEL = 4;
/** [s] What was not recorded for longer is not there. */
export const FRESH = 0.2;
const MARKED = new Map([[1, 'join'], [2, 'parameters'], [5, 'end'], [6, 'reload'], [7, 'change']]);  // kinds of feltwire.Event
const PER_NEWTON = 0.01;  // [m] of a recorded picture's arrow

/** Places in a row of a hand. Vectors have three numbers, the quaternion (w, x, y, z) four. World frame, SI units; NaN: not known. */
export const ROW = {position: 0, orientation: 3, elastic: 7, friction: 10, held: 13, age: 16, proxy: 17, depth: 20, size: 21};
/** Places in a row of an account. */
export const ACCOUNT = {balance: 0, cut: 1, reason: 2, size: 3};

/** Size of the sum of the elastic and the frictional force [N]. @param {Float32Array} rows @param {number} row where the hand's begins */
export function askedForce(rows, row) {
  const [e, f] = [row + ROW.elastic, row + ROW.friction];
  return Math.hypot(rows[e] + rows[f], rows[e + 1] + rows[f + 1], rows[e + 2] + rows[f + 2]);
}

/** Rows by rising time. */
export class Table {
  /** @param {number} width numbers a row */
  constructor(width) {
    this.width = width;
    this.count = 0;
    this.times = new Float64Array(256);  // [s] since the recording began
    this.rows = new Float32Array(256 * width);
  }

  /** @param {number} time @returns {number} where the new row begins in `rows` */
  add(time) {
    if (this.count === this.times.length) {
      this.times = grown(this.times);
      this.rows = grown(this.rows);
    }
    this.times[this.count] = time;
    return this.width * this.count++;
  }

  /** @param {number} time @returns {number} the last row that is not later, or -1 */
  before(time) {
    let low = 0;
    let high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  get bytes() {
    return this.times.byteLength + this.rows.byteLength;
  }
}

function grown(array) {
  const larger = new array.constructor(2 * array.length);
  larger.set(array);
  return larger;
}

/** What one chunk has. */
export class Segment {
  constructor() {
    this.own = new Table(ROW.size);  // the hand of the client that recorded
    this.accounts = new Table(ACCOUNT.size);
    this.hands = new Map();  // number -> Table, of /scene/hands where the file has it, else of /scene/picture
    this.marks = [];  // {time, text}: of /scene/events, those that people ask for
    this.pictures = [];  // {time, bytes}: /scene/picture, for the bodies
    this.transforms = [];  // likewise: /scene/transforms
    this.geometry = null;  // bytes: the last /scene/geometry
    this.kept = 0;  // [bytes] of the chunk that the pictures hold
    this.used = 0;
  }

  /** Whether the client that recorded only watched. */
  get watches() {
    const {count, rows} = this.accounts;
    for (let i = 0; i < count; ++i) if (rows[i * ACCOUNT.size + ACCOUNT.reason] === OBSERVER) return true;
    return false;
  }

  /** @returns {Table[]} of all hands */
  handTables() {
    return [...(this.watches ? [] : [this.own]), ...this.hands.values()];
  }

  get bytes() {
    let sum = this.own.bytes + this.accounts.bytes + this.kept;
    for (const table of this.hands.values()) sum += table.bytes;
    return sum;
  }
}

/**
 * Throws a RangeError where a record or a message does not fit.
 * @param {Uint8Array} records of a chunk @param {import('./mcap.js').McapFile} mcap @param {bigint} start of the recording [ns]
 */
export function readSegment(records, mcap, start) {
  const segment = new Segment();
  const cursor = new Cursor(records);
  const live = [...mcap.channels.values()].includes('/scene/hands');
  const [startLow, startHigh] = [Number(start & 0xffffffffn), Number(start >> 32n)];
  while (cursor.left > 0) {
    const opcode = cursor.u8();
    const end = cursor.u64() + cursor.at;
    if (end > records.length) throw new RangeError(say('file.range.record'));
    if (opcode === CHANNEL) mcap.takeChannel(new Cursor(records.subarray(cursor.at, end)));
    if (opcode === MESSAGE) {
      const topic = mcap.channels.get(cursor.u16());
      cursor.u32();
      const low = cursor.u32();
      const time = ((cursor.u32() - startHigh) * 2 ** 32 + (low - startLow)) / 1e9;
      cursor.take(8);  // time of publication
      if (cursor.at > end) throw new RangeError(say('file.range.cut'));
      take(segment, topic, time, cursor.view, cursor.at, end, live);
    }
    cursor.at = end;
  }
  return segment;
}

/** @param {boolean} live whether hands are in /scene/hands */
function take(segment, topic, time, view, at, end, live) {
  const part = () => {
    segment.kept = view.byteLength;  // A view of a part keeps the whole chunk.
    return new DataView(view.buffer, view.byteOffset + at, end - at);
  };
  if (topic === '/hand/sample') takeSample(segment.own, time, new Fields(view, at, end));
  if (topic === '/hand/account') takeAccount(segment.accounts, time, new Fields(view, at, end));
  if (topic === '/scene/picture') {
    segment.pictures.push({time, bytes: part()});
    if (!live) takeHands(segment.hands, time, new Fields(view, at, end));
  }
  if (topic === '/scene/events') takeEvent(segment.marks, time, new Fields(view, at, end));
  if (topic === '/scene/hands') takeLiveHands(segment.hands, time, new Fields(view, at, end));
  if (topic === '/scene/transforms') segment.transforms.push({time, bytes: part()});
  if (topic === '/scene/geometry') segment.geometry = part();
}

/** Protobuf has x, y, z, w. */
function putQuaternion(fields, rows, at) {
  fields.numbers(rows, at, 4);
  const [x, y, z, w] = rows.subarray(at, at + 4);
  rows.set([w, x, y, z], at);
}

function takeSample(table, time, fields) {
  const row = table.add(time);
  const {rows} = table;
  rows.fill(0, row, row + ROW.proxy);
  rows.fill(NaN, row + ROW.proxy, row + ROW.size);
  rows[row + ROW.orientation] = 1;
  while (fields.next()) {
    switch (fields.number) {
      case 2: fields.numbers(rows, row + ROW.position, 3); break;
      case 3: putQuaternion(fields, rows, row + ROW.orientation); break;
      case 4: fields.numbers(rows, row + ROW.elastic, 3); break;
      case 5: fields.numbers(rows, row + ROW.friction, 3); break;
      case 6: fields.numbers(rows, row + ROW.held, 3); break;
      case 8: rows[row + ROW.age] = fields.value; break;
      default:
    }
  }
}

function takeAccount(table, time, fields) {
  const row = table.add(time);
  const {rows} = table;
  rows[row + ACCOUNT.balance] = NaN;
  rows[row + ACCOUNT.cut] = rows[row + ACCOUNT.reason] = 0;
  while (fields.next()) {
    if (fields.number === 2) rows[row + ACCOUNT.balance] = fields.value;
    if (fields.number === 3) rows[row + ACCOUNT.cut] = fields.value;
    if (fields.number === 4) rows[row + ACCOUNT.reason] = fields.value;
  }
}

function takeEvent(marks, time, event) {
  let [kind, number] = [0, 0];
  while (event.next()) {
    if (event.number === 3) kind = event.value;
    if (event.number === 5) number = event.value;
  }
  const name = MARKED.get(kind);
  if (name) marks.push({time, text: say(`mark.${name}`, {number})});
}

/** The hands of a picture: entities "hand N", a sphere each, and an arrow where there is force. */
function takeHands(hands, time, update) {
  while (update.next()) {
    if (update.number !== 2) continue;
    const entity = update.message();
    let number = null;
    const pose = new Float32Array(ROW.size).fill(NaN);
    pose.set([0, 0, 0], ROW.held);
    while (entity.next()) {
      if (entity.number === 3) number = /^hand (\d{1,9})$/.exec(entity.text())?.[1];
      if (entity.number === 9) takePose(entity.message(), pose);
      if (entity.number === 7) takeArrow(entity.message(), pose);
    }
    if (!number || Number.isNaN(pose[0])) continue;
    addHand(hands, Number(number), time, pose);
  }
}

function addHand(hands, number, time, values) {
  if (!hands.has(number)) hands.set(number, new Table(ROW.size));
  const table = hands.get(number);
  const row = table.add(time);  // It may take other room for the rows.
  table.rows.set(values, row);
}

/** The hands of a feltwire.Hands. */
function takeLiveHands(hands, time, all) {
  const values = new Float32Array(ROW.size);
  while (all.next()) {
    if (all.number !== 2) continue;
    let number = 0;
    values.fill(0);
    values[ROW.orientation] = 1;
    values[ROW.age] = NaN;
    for (const hand = all.message(); hand.next();) {
      switch (hand.number) {
        case 1: number = hand.value; break;
        case 2: hand.numbers(values, ROW.position, 3); break;
        case 3: putQuaternion(hand, values, ROW.orientation); break;
        case 4: hand.numbers(values, ROW.proxy, 3); break;
        case 5: hand.numbers(values, ROW.elastic, 3); break;
        case 6: hand.numbers(values, ROW.friction, 3); break;
        case 7: hand.numbers(values, ROW.held, 3); break;
        case 8: values[ROW.depth] = hand.value; break;
        default:
      }
    }
    addHand(hands, number, time, values);
  }
}

function takePose(primitive, out) {
  while (primitive.next()) if (primitive.number === 1) readPose(primitive.message(), out, ROW.position, ROW.orientation);
}

/** A pose's position, and its orientation as w, x, y, z. */
export function readPose(fields, out, position, orientation) {
  out.fill(0, position, position + 3);
  out.set([1, 0, 0, 0], orientation);
  while (fields.next()) {
    if (fields.number === 1) fields.numbers(out, position, 3);
    if (fields.number === 2) putQuaternion(fields, out, orientation);
  }
}

/** The force is along the arrow's x axis, as long as its shaft and head. */
function takeArrow(arrow, out) {
  const pose = new Float32Array(7);
  let length = 0;
  while (arrow.next()) {
    if (arrow.number === 1) readPose(arrow.message(), pose, 0, 3);
    if (arrow.number === 2 || arrow.number === 4) length += arrow.value;
  }
  const [w, x, y, z] = pose.subarray(3);
  const force = length / PER_NEWTON;
  out.set([force * (1 - 2 * (y * y + z * z)), 2 * force * (x * y + w * z), 2 * force * (x * z - w * y)], ROW.held);
}
