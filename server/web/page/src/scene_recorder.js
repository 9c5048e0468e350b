// Records the scene that is watched, in this browser: the messages of the Foxglove protocol, which a ticket opens, into an MCAP file.

import {say} from './language.js';
import {McapWriter} from './mcap_writer.js';
import {socketAddress} from './socket.js';

const PROTOCOLS = ['foxglove.sdk.v1', 'foxglove.websocket.v1'];
const MESSAGE = 1;  // first byte of a message of a channel
const HEAD = 13;  // [bytes] before its data
const ONCE = '/scene/geometry';  // is as old as the scene
const MOST = 256 * 2 ** 20;  // [bytes]

const bytesOf = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));

export class SceneRecorder {
  /**
   * @param {string} path of the ticket at this server @param {object} scene the server's message of it @param {string} version of the server
   * @param {(why: string) => void} ended called once, if it ends by itself
   */
  constructor(path, scene, version, ended) {
    this.name = scene.name;
    this.ended = ended;
    this.writer = new McapWriter(`feltwire ${version}, live page`);
    this.writer.addMetadata('feltwire', {scene: scene.name, version, kind: 'live page'});
    this.writer.addMetadata('scene', {message: JSON.stringify({...scene, guides: [], tools: []})});
    this.channels = new Map();  // subscription -> {id, topic}
    this.early = [];  // messages that came before the first picture
    this.first = null;  // [ns] time of the first picture
    this.last = null;
    this.socket = new WebSocket(socketAddress(`.${path}`), PROTOCOLS);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onmessage = ({data}) => (typeof data === 'string' ? this.#text(JSON.parse(data)) : this.#take(data));
    this.socket.onclose = ({reason}) => this.#end(reason || say('record.why.lost'));
  }

  /** [s] that are recorded. */
  get seconds() {
    return this.first === null ? 0 : Number(this.last - this.first) / 1e9;
  }

  /** @returns {Uint8Array[] | null} the file in parts; null: nothing was recorded */
  stop() {
    this.socket.onmessage = this.socket.onclose = null;
    this.socket.close();
    return this.first === null ? null : this.writer.finish();
  }

  #text(message) {
    if (message.op !== 'advertise') return;
    const schemas = new Map();
    for (const {id, topic, encoding, schemaName, schemaEncoding, schema} of message.channels) {
      if (!schemas.has(schemaName)) schemas.set(schemaName, this.writer.addSchema(schemaName, schemaEncoding ?? 'protobuf', bytesOf(schema)));
      this.channels.set(id, {id: this.writer.addChannel(schemas.get(schemaName), topic, encoding), topic});
    }
    this.socket.send(JSON.stringify({op: 'subscribe', subscriptions: message.channels.map(({id}) => ({id, channelId: id}))}));
  }

  #take(buffer) {
    const view = new DataView(buffer);
    if (view.byteLength < HEAD || view.getUint8(0) !== MESSAGE) return;
    const channel = this.channels.get(view.getUint32(1, true));
    if (!channel) return;
    const message = {...channel, time: view.getBigUint64(5, true), data: new Uint8Array(buffer, HEAD)};
    if (this.first === null) {
      this.early.push(message);
      if (channel.topic !== '/scene/hands') return;
      this.first = this.last = message.time;
      for (const early of this.early.splice(0)) this.#write(early);
      return;
    }
    this.#write(message);
    if (this.writer.size > MOST) this.#end(say('record.why.full'));
  }

  /** A message that is older than the recording gets the time of its begin. */
  #write({id, topic, time, data}) {
    const now = topic === ONCE || time < this.first ? this.last : time;
    if (now > this.last) this.last = now;
    this.writer.write(id, now, data);
  }

  #end(why) {
    this.socket.onclose = this.socket.onmessage = null;
    this.socket.close();
    this.ended(why);
  }
}
