// Reads MCAP files with @mcap/core and their messages with protobufjs: another implementation of both.
//   node read.mjs FILE.mcap ...
// A file that was cut is read from its beginning; a whole one by its index, too. Exit status 1 when anything differs.

import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import { readFileSync } from "node:fs";
import { basename } from "node:path";
import protobuf from "protobufjs";
import "protobufjs/ext/descriptor.js";

const decompressHandlers = { zstd: (bytes, size) => decompress(bytes, new Uint8Array(Number(size))) };
const kMagic = Buffer.from("\x89MCAP0\r\n", "latin1");

function require(good, what) {
  if (!good) throw new Error(what);
}

function readable(bytes) {
  return {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => bytes.subarray(Number(offset), Number(offset + length)),
  };
}

/// From the beginning: [record, ...] without the chunks.
function stream(bytes, whole) {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  const records = [];
  reader.append(bytes);
  for (let record; (record = reader.nextRecord()); ) records.push(record);
  require(reader.done() === whole, "the stream ends elsewhere");
  return records;
}

/// Types by schema, made of the descriptors in the file.
function decoder(schema) {
  if (schema.encoding !== "protobuf" || !schema.name.match(/^(feltwire|foxglove)\./)) return undefined;
  return protobuf.Root.fromDescriptor(schema.data).lookupType(schema.name);
}

const kSamples = 3;  // a kind of feltwire.Event
const vector = (v) => v && [v.x, v.y, v.z].every(Number.isFinite);
const checks = {
  "feltwire.Sample": (m) => vector(m.position) && vector(m.held) && m.age >= -1 && m.orientation.w !== undefined,
  "feltwire.Account": (m, type) => m.cut >= 0 && m.cut <= 1 && m.noForce in type.lookupEnum("NoForce").valuesById,
  "feltwire.Event": (m, type) => Number(m.number) > 0 && Number(m.time) > 0 && m.kind > 0 && m.kind in type.lookupEnum("Kind").valuesById &&
    m.outcome in type.lookupEnum("Outcome").valuesById && (m.kind === kSamples) === (m.payload.length > 1 && m.outcome > 0),
  "foxglove.PoseInFrame": (m) => m.frameId === "world" && vector(m.pose.position) && m.timestamp.seconds > 0,
  "foxglove.SceneUpdate": (m) => m.entities.length + m.deletions.length > 0 && m.deletions.every((d) => d.id) &&
    m.entities.every((e) => e.triangles.length === 0 && e.arrows.length <= 1 &&
      vector((e.id.startsWith("hand") ? e.spheres : e.cubes)[0].size)),
};

async function read(file) {
  const bytes = readFileSync(file);
  const whole = bytes.length > 16 && bytes.subarray(-8).equals(kMagic);
  const records = stream(bytes, whole);
  const messages = records.filter((record) => record.type === "Message");
  const schemas = new Map(records.filter((r) => r.type === "Schema").map((r) => [r.id, r]));
  const channels = new Map(records.filter((r) => r.type === "Channel").map((r) => [r.id, r]));
  const types = new Map([...schemas].map(([id, schema]) => [id, decoder(schema)]));
  const times = new Map();
  let decoded = 0;
  for (const message of messages) {
    const schema = channels.get(message.channelId).schemaId;
    const type = types.get(schema);
    if (!type) continue;
    const fields = type.decode(message.data);
    require(checks[schemas.get(schema).name](fields, type), `${schemas.get(schema).name}: ${JSON.stringify(fields)}`);
    const rises = fields.number ?? fields.time;  // several events may have one time
    if (rises !== undefined) {
      require(!(Number(rises) <= times.get(schema)), "time or number does not rise");
      times.set(schema, Number(rises));
    }
    ++decoded;
  }
  if (whole) {
    const reader = await McapIndexedReader.Initialize({ readable: readable(bytes), decompressHandlers });
    require(Number(reader.statistics.messageCount) === messages.length, "the statistics have another count");
    for (const chunk of reader.chunkIndexes) {
      const at = Number(chunk.chunkStartOffset);
      require(bytes[at] === 6 && bytes.readBigUInt64LE(at + 1) + 9n === chunk.chunkLength, "a chunk is not where it is said");
    }
    let indexed = 0, last = 0n;
    for await (const message of reader.readMessages({ validateCrcs: true })) {
      require(message.logTime >= last, "the index is not in order");
      last = message.logTime;
      ++indexed;
    }
    require(indexed === (reader.chunkIndexes.length > 0 ? messages.length : 0), "the index has another count");
    // A part, by the index alone.
    const middle = (reader.statistics.messageStartTime + reader.statistics.messageEndTime) / 2n;
    const expected = messages.filter((message) => message.logTime >= middle).length;
    let later = 0;
    if (reader.chunkIndexes.length > 0)
      for await (const _ of reader.readMessages({ startTime: middle })) ++later;
    require(reader.chunkIndexes.length === 0 || later === expected, "the index finds other messages");
    let attachments = 0, metadata = 0;
    for await (const _ of reader.readAttachments({ validateCrcs: true })) ++attachments;
    for await (const _ of reader.readMetadata()) ++metadata;
    require(attachments === records.filter((r) => r.type === "Attachment").length, "attachments are missing");
    require(metadata === records.filter((r) => r.type === "Metadata").length, "metadata are missing");
  }
  console.log(`${basename(file)}: ${whole ? "whole" : "cut"}, ${messages.length} messages, ${decoded} decoded`);
}

let failed = false;
for (const file of process.argv.slice(2)) {
  try {
    await read(file);
  } catch (error) {
    console.error(`${basename(file)}: ${error.stack}`);
    failed = true;
  }
}
require(process.argv.length > 2, "no file was given");
process.exit(failed ? 1 : 0);
