// A server that speaks feltwire.live.v1 and plays hands: some press a floor and rub it, some press a ball.
// By hand: node mock_server.mjs PAGE_FOLDER [HANDS] [BODIES] prints the link to open.

import {createHash} from 'node:crypto';
import {readFileSync} from 'node:fs';
import {createServer} from 'node:http';
import {join} from 'node:path';
import {checkMembers, REASONS} from './members.mjs';
import {geometryMessage, Play} from './play.mjs';

export const TOKEN = 'an-open-secret';
export const ADMIN = 'the-token-of-an-admin';
export const RECORDING = 'recording-20261130T120000.000Z-room.mcap';
const HEADERS = {
  'Content-Security-Policy': "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; " +
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
  'X-Content-Type-Options': 'nosniff', 'Referrer-Policy': 'no-referrer', 'Cross-Origin-Opener-Policy': 'same-origin',
  'Cross-Origin-Resource-Policy': 'same-origin', 'Cache-Control': 'no-store', 'Content-Encoding': 'gzip',
};

/** @param {Buffer} payload @param {number} opcode 1 text, 2 binary, 8 close @returns {Buffer} a frame as a server sends it */
function frame(payload, opcode) {
  const {length} = payload;
  const head = length < 126 ? Buffer.alloc(2) : Buffer.alloc(length < 65536 ? 4 : 10);
  head[0] = 0x80 | opcode;
  head[1] = length < 126 ? length : length < 65536 ? 126 : 127;
  if (head[1] === 126) head.writeUInt16BE(length, 2);
  if (head[1] === 127) head.writeBigUInt64BE(BigInt(length), 2);
  return Buffer.concat([head, payload]);
}

/** One viewer. Its messages are short, so a frame has at most 125 bytes or a length of two bytes. */
class Viewer {
  constructor(socket, onText) {
    this.socket = socket;
    let rest = Buffer.alloc(0);
    socket.on('error', () => {});
    socket.on('data', (data) => {
      rest = Buffer.concat([rest, data]);
      while (rest.length >= 6) {
        const long = (rest[1] & 127) === 126;
        const at = long ? 8 : 6;
        const length = long ? rest.readUInt16BE(2) : rest[1] & 127;
        if (rest.length < at + length) return;
        const mask = rest.subarray(at - 4, at);
        const text = Buffer.from(rest.subarray(at, at + length).map((byte, i) => byte ^ mask[i % 4]));
        const opcode = rest[0] & 15;
        rest = rest.subarray(at + length);
        if (opcode === 1) onText(JSON.parse(text.toString()));
        if (opcode === 8) socket.end(frame(text, 8));
      }
    });
  }

  json(message) {
    checkMembers(message);
    this.socket.write(frame(Buffer.from(JSON.stringify(message)), 1));
  }

  binary(buffer) {
    if (this.socket.writableLength < 1 << 20) this.socket.write(frame(buffer, 2));  // A slow viewer skips pictures.
  }

  close(code, reason = '') {
    const payload = Buffer.alloc(2 + Buffer.byteLength(reason));
    payload.writeUInt16BE(code);
    payload.write(reason, 2);
    this.socket.end(frame(payload, 8));
  }
}

/** A histogram to which each reading adds 5 times up to 10 us and 20 longer than all; another scene's says something else. */
function times(readings) {
  const line = (scene, limit, count) => `feltwire_answer_seconds_bucket{scene="${scene}",le="${limit}"} ${count}\n`;
  return ['room', 'other'].map((scene, i) => line(scene, '1e-05', 100 + (i + 1) * 5 * readings) + line(scene, '0.0001', 100 + (i + 1) * 5 * readings) +
    line(scene, '+Inf', 100 + (i + 1) * 25 * readings)).join('');
}

/**
 * @param {{folder: string, port?: number, hands?: number, bodies?: number, token?: string, file?: Buffer}} options
 * @returns {Promise<{url: string, port: number, watched: string[], requests: string[], play: Play, drop: Function, send: Function, log: Function, stop: Function}>}
 */
export async function startServer({folder, port = 0, hands = 2, bodies = 1, token = TOKEN, file = Buffer.from('no recording')}) {
  const assets = JSON.parse(readFileSync(join(folder, 'assets.json'), 'utf8'));
  const play = new Play(hands, bodies);
  const viewers = new Set();
  const requests = [];
  const watched = [];
  let readings = 0;
  const asked = [];  // by admins
  const server = createServer((request, response) => {
    requests.push(request.url);
    if (request.url === '/metrics') return response.writeHead(200, {'Content-Type': 'text/plain'}).end(times(++readings));
    if (request.url === '/recording?ticket=fw_download') {
      return response.writeHead(200, {'Content-Type': 'application/octet-stream', 'Content-Disposition': `attachment; filename="${RECORDING}"`}).end(file);
    }
    const asset = assets.find(({path}) => path === request.url);
    if (!asset) return response.writeHead(404).end();
    const name = asset.path === '/' ? 'index.html' : asset.path.slice(1);
    return response.writeHead(200, {...HEADERS, 'Content-Type': asset.type}).end(readFileSync(join(folder, `${name}.gz`)));
  });

  let recording = null;  // [ms] when it began
  let kept = [];
  let ended = 'none';
  const sendRecordings = () => viewers.forEach((viewer) => viewer.admin && viewer.json({
    type: 'recordings', scene: 'room', running: recording && RECORDING, seconds: recording ? Math.floor((Date.now() - recording) / 1000) : 3, bytes: 1_200_000, ended, kept,
  }));
  const record = (viewer, wanted) => {
    if ((wanted === 'start') === (recording !== null)) return viewer.json({type: 'refused', text: 'a recording of the scene runs already; stop it first'});
    recording = wanted === 'start' ? Date.now() : null;
    ended = recording ? 'none' : 'asked';
    kept = recording ? kept : [{name: RECORDING, bytes: file.length}];
    return sendRecordings();
  };
  const materials = play.scene('room').objects.map(() => ({stiffness: 1000, damping: 0, static_friction: 0.5, dynamic_friction: 0.4, viscous_friction: 0}));
  let gravity = [0, 0, -9.81];
  const sendMaterials = (viewer) => viewer.json({type: 'materials', version: play.version, gravity, objects: materials});
  const sendScene = (viewer, name) => {
    viewer.json(play.scene(name));
    sendMaterials(viewer);
    for (const {index, shape} of play.shapes) viewer.binary(geometryMessage(index, play.version, shape));
  };
  const welcome = (viewer, message) => {
    if (!viewers.has(viewer)) {
      if (message.token !== token) return viewer.close(4401, 'unknown token');
      viewers.add(viewer);
      viewer.json({type: 'hello', version: 'mock', observes: play.observes, small_debt: 1e-6, scenes: ['room', 'other'], role: 'observer', modes: ['contact_frame', 'per_axis'], reasons: REASONS,
        wakeup_limits: [2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 1e-2], round_trip_limits: [2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 0.02, 0.1]});
      sendScene(viewer, 'room');
    }
    if (message.ticket) viewer.json({type: 'ticket', scene: message.ticket, path: `/foxglove?ticket=fw_${message.ticket}`, seconds: 60});
    if (message.admin === ADMIN) viewer.admin = true;
    if (message.recording) record(viewer, message.recording);
    if (message.download) viewer.json({type: 'download', name: message.download, path: '/recording?ticket=fw_download'});
    if (message.admin) viewer.json(message.admin === ADMIN ? {type: 'admin', role: 'admin'} : {type: 'refused', text: 'the token is not good'});
    if (message.set || message.evict || message.reload || message.record) asked.push(message);
    if (message.record) viewer.json({type: 'changed', text: 'flight record: /var/flights/flight-1-room.mcap'});
    if (message.set?.stiffness > 1e9) {
      viewer.json({type: 'refused', text: 'stiffness: must be at most 1e+09 [N/m]'});
    } else if (message.set) {
      const {object, gravity: wanted, ...fields} = message.set;
      if (object) Object.assign(materials[play.scene('room').objects.findIndex(({name}) => name === object)], fields);
      if (wanted) gravity = wanted;
      viewer.json({type: 'changed', text: 'changed'});
      sendMaterials(viewer);
    }
    if (message.watch) {
      watched.push(message.watch);
      sendScene(viewer, message.watch);
    }
  };
  server.on('upgrade', (request, socket) => {
    requests.push(request.url);
    if (request.url !== '/live') return socket.end('HTTP/1.1 404 Not Found\r\nConnection: close\r\n\r\n');
    const accept = createHash('sha1').update(`${request.headers['sec-websocket-key']}258EAFA5-E914-47DA-95CA-C5AB0DC85B11`).digest('base64');
    socket.write(`HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${accept}\r\n` +
      'Sec-WebSocket-Protocol: feltwire.live.v1\r\n\r\n');
    const viewer = new Viewer(socket, (message) => welcome(viewer, message));
    return socket.on('close', () => viewers.delete(viewer));
  });

  const pictures = setInterval(() => {
    if (play.silent) return;
    const [picture, surfaces] = [play.picture(), play.surfaces()];
    for (const viewer of viewers) {
      viewer.binary(picture);
      if (play.modelled) viewer.binary(surfaces);
    }
  }, 1000 / 60);
  const tables = setInterval(() => {
    sendRecordings();
    for (const viewer of viewers) viewer.json(play.sessions());
  }, 500);
  const drop = (code, reason) => {
    for (const viewer of viewers) viewer.close(code, reason);
    viewers.clear();
  };
  await new Promise((resolve) => server.listen(port, '127.0.0.1', resolve));
  const taken = server.address().port;
  return {
    url: `http://127.0.0.1:${taken}/`, port: taken, watched, asked, requests, play, drop,
    send: (bytes) => viewers.forEach((viewer) => viewer.binary(bytes)),
    startRecording: () => (recording = Date.now()),
    endRecording: (why) => {
      recording = null;
      ended = why;
      sendRecordings();
    },
    log: (level, text) => viewers.forEach((viewer) => viewer.json({type: 'log', level, text})),
    stop: () => new Promise((resolve) => {
      clearInterval(pictures);
      clearInterval(tables);
      drop(1001, '');
      server.close(resolve);
      server.closeAllConnections();
    }),
  };
}

if (process.argv[1] === new URL(import.meta.url).pathname) {
  const [folder, hands, bodies] = process.argv.slice(2);
  const server = await startServer({folder, hands: Number(hands ?? 2), bodies: Number(bodies ?? 1)});
  console.log(`${server.url}#token=${TOKEN}`);
}
