// Looks on at a server with the client of @foxglove/ws-protocol, and decodes with protobufjs by the schemas that the server
// advertises: other implementations of both.
//   node look.mjs http://127.0.0.1:PORT TOKEN
// Waits until it has seen a hand that is held by a force. Exit status 1 when anything differs.

import FoxgloveWebSocket from '@foxglove/ws-protocol';
import protobuf from 'protobufjs';
import 'protobufjs/ext/descriptor.js';
import WebSocket from 'ws';

const [page, token] = process.argv.slice(2);
const PATIENCE = 30_000;  // [ms]
const {FoxgloveClient} = FoxgloveWebSocket;

function require(good, what) {
  if (!good) throw new Error(what);
}

async function ticket(scene = 'room') {
  const answer = await fetch(`${page}/ticket?scene=${scene}`, {headers: {Authorization: `Bearer ${token}`}});
  require(answer.status === 200, `a ticket is refused: ${answer.status}`);
  return (await answer.text()).trim();
}

/** How the server answers a request for a WebSocket: the subprotocol that it chose, or its HTTP status. */
function opened(address, protocols, options = {}) {
  return new Promise((resolve, reject) => {
    const socket = new WebSocket(address, protocols, options);
    socket.onopen = () => resolve(socket);
    socket.on('unexpected-response', (_, response) => resolve(response.statusCode));
    socket.onerror = () => reject(new Error('no connection'));
  });
}

function decoder(channel) {
  require(channel.encoding === 'protobuf' && channel.schemaEncoding === 'protobuf', `${channel.topic} is no Protobuf`);
  return protobuf.Root.fromDescriptor(Buffer.from(channel.schema, 'base64')).lookupType(channel.schemaName);
}

const finite = (v) => v && [v.x, v.y, v.z].every(Number.isFinite);
const checks = {
  '/scene/geometry': (m) => m.deletions[0].type === 1 && m.entities.length > 1 &&
    m.entities.every(({triangles: [list]}) => list.points.every(finite) && list.indices.length % 3 === 0 &&
      list.indices.every((index) => index < list.points.length)),
  '/scene/transforms': (m) => m.transforms.every((t) => t.parentFrameId === 'world' && t.childFrameId.startsWith('body ') &&
    finite(t.translation) && t.rotation),
  '/scene/picture': (m) => m.entities.every((e) => e.id.startsWith('hand ') && e.frameId === 'world' && finite(e.spheres[0].pose.position)),
  '/scene/hands': (m) => m.time > 0 && m.hands.every((h) => h.number > 0 && finite(h.position) && h.reasons.length > 0),
};

/** Subscribes to all channels until each has been seen and a hand is held. */
function look(address, protocol) {
  return new Promise((resolve, reject) => {
    const patience = setTimeout(() => reject(new Error(`no hand is held; seen: ${JSON.stringify([...seen])}`)), PATIENCE);
    const client = new FoxgloveClient({ws: new WebSocket(address, [protocol])});
    const channels = new Map();  // by subscription
    const seen = new Map();  // messages by topic
    let name = '', held = false, asked = false, ended = false, complaint = '';
    const end = (error) => {
      ended = true;
      clearTimeout(patience);
      client.close();
      error ? reject(error) : resolve();
    };
    client.on('error', end);
    client.on('serverInfo', (info) => (name = info.name));
    client.on('status', (status) => {
      complaint = status.message;
      if (!asked) end(new Error(status.message));
    });
    client.on('advertise', (advertised) => {
      for (const channel of advertised) channels.set(client.subscribe(channel.id), {topic: channel.topic, type: decoder(channel)});
    });
    client.on('message', ({subscriptionId, timestamp, data}) => {
      if (ended) return;
      try {
        const {topic, type} = channels.get(subscriptionId);
        const message = type.decode(new Uint8Array(data.buffer, data.byteOffset, data.byteLength));
        require(checks[topic](message), `${topic}: ${JSON.stringify(message)}`);
        require(Math.abs(Number(timestamp / 1_000_000n) - Date.now()) < 60_000, `${topic} has the time ${timestamp}`);
        seen.set(topic, (seen.get(topic) ?? 0) + 1);
        if (topic === '/scene/hands') held ||= message.hands.some((h) => Math.hypot(h.held.x, h.held.y, h.held.z) > 0.1);
        if (held && !asked) {
          asked = true;
          client.fetchAsset('package://none', 1);  // which this server does not offer
        }
        if (['/scene/geometry', '/scene/picture', '/scene/hands'].every((t) => seen.has(t)) && complaint) {
          require(name.startsWith('feltwire-server '), `the server calls itself ${name}`);
          require(complaint.includes('fetchAsset'), complaint);
          require(seen.get('/scene/geometry') === 1, 'the geometry came again though nothing changed');
          console.log(`${protocol}: ${[...seen].map(([t, n]) => `${n} ${t}`).join(', ')}`);
          end();
        }
      } catch (error) {
        end(error);
      }
    });
  });
}

require((await fetch(`${page}/ticket?scene=room`)).status === 401, 'a ticket without a token');
require((await fetch(`${page}/ticket?scene=other`, {headers: {Authorization: `Bearer ${token}`}})).status === 404, 'a ticket for no scene');

await look(await ticket(), 'foxglove.websocket.v1');
await look(await ticket(), 'foxglove.sdk.v1');

// Any page may show a ticket; once.
const address = await ticket();
const first = await opened(address, ['foxglove.websocket.v1', 'foxglove.sdk.v1'], {origin: 'https://app.foxglove.dev'});
require(first.protocol === 'foxglove.sdk.v1', `the subprotocol is ${first.protocol}`);
require(await opened(address, ['foxglove.sdk.v1']) === 403, 'a ticket was taken twice');
require(await opened(`${address}x`, ['foxglove.sdk.v1']) === 403, 'a wrong ticket was taken');
first.close();
// A request that fails before the ticket check leaves the ticket valid.
const kept = await ticket();
require(await opened(kept, ['other']) === 400, 'another subprotocol was taken');
const second = await opened(kept, ['foxglove.websocket.v1']);
require(second.protocol === 'foxglove.websocket.v1', `the subprotocol is ${second.protocol}`);
second.close();
