// Makes a long recording of a short one, for tests of large files: the same messages again and again, each time later, in chunks that are
// not compressed. By hand, in the work folder of run-replay-tests: node tests/grow_recording.mjs recordings/slide.mcap long.mcap 500

import {closeSync, openAsBlob, openSync, writeSync} from 'node:fs';
import {basename, resolve} from 'node:path';

const MESSAGE = 5;
const MAGIC = Buffer.from('\x89MCAP0\r\n', 'latin1');

const u16 = (value) => Buffer.from([value & 255, value >> 8]);
const u32 = (value) => {
  const bytes = Buffer.alloc(4);
  bytes.writeUInt32LE(value);
  return bytes;
};
const u64 = (value) => {
  const bytes = Buffer.alloc(8);
  bytes.writeBigUInt64LE(BigInt(value));
  return bytes;
};
const text = (value) => Buffer.concat([u32(Buffer.byteLength(value)), Buffer.from(value)]);
const record = (opcode, ...parts) => {
  const content = Buffer.concat(parts);
  return Buffer.concat([Buffer.from([opcode]), u64(content.length), content]);
};

/** Moves all messages of a chunk's records. @param {bigint} by [ns] */
function shift(records, by) {
  for (let at = 0; at < records.length;) {
    const length = Number(records.readBigUInt64LE(at + 1));
    if (records[at] === MESSAGE) for (const place of [at + 15, at + 23]) records.writeBigUInt64LE(records.readBigUInt64LE(place) + by, place);
    at += 9 + length;
  }
}

/** @param {string} from a recording @param {string} to the file to write @param {number} mebibytes its size, at least */
export async function growRecording(from, to, mebibytes) {
  const {McapFile} = await import('../page/src/replay/mcap.js');
  const blob = await openAsBlob(from);
  blob.name = basename(from);
  const mcap = await McapFile.open(blob);
  const chunks = await Promise.all(mcap.chunks.map(async (chunk) => ({...chunk, records: Buffer.from(await mcap.read(chunk))})));
  const once = mcap.chunks.at(-1).to - mcap.chunks[0].from + 1_000_000n;
  const channels = Buffer.concat([...mcap.channels].map(([id, topic]) => record(4, u16(id), u16(0), text(topic), text('protobuf'), text(''))));
  const file = openSync(to, 'w');
  let size = 0;
  const put = (bytes) => {
    writeSync(file, bytes);
    size += bytes.length;
  };
  put(Buffer.concat([MAGIC, record(1, text(''), text('grown')), channels]));
  const indexes = [];
  for (let later = 0n; size < mebibytes * 2 ** 20; later += once) {
    for (const {from: begin, to: end, records} of chunks) {
      const at = size;
      const times = [u64(begin + later), u64(end + later)];
      put(record(6, ...times, u64(records.length), u32(0), text(''), u64(records.length), records));
      indexes.push(record(8, ...times, u64(at), u64(size - at), text(''), u64(0), text(''), u64(records.length), u64(records.length)));
      shift(records, once);
    }
  }
  put(record(15, u32(0)));
  const summary = size;
  put(channels);
  for (const index of indexes) put(index);
  put(record(2, u64(summary), u64(0), u32(0)));
  put(MAGIC);
  closeSync(file);
}

if (process.argv[1] === new URL(import.meta.url).pathname) {
  const [from, to, mebibytes] = process.argv.slice(2);
  await growRecording(resolve(from), resolve(to), Number(mebibytes));
}
