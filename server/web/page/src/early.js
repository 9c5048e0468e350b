// Opens the connection and makes the context of the 3D view before app.js has arrived: the server's first messages travel, and the
// browser's process for graphics starts, while the browser reads that script. A file of its own; app.js imports the same file.

import {makeContext} from './context.js';
import {openSocket, takeToken} from './socket.js';
import {standsAlone} from './stands_alone.js';

let early = null;

const token = standsAlone() ? null : takeToken();
if (token) {
  const events = [];
  const socket = openSocket(token);
  socket.onmessage = (event) => events.push(event);
  socket.onclose = (event) => events.push(event);
  early = {token, socket, events};
  makeContext(document.getElementById('canvas'));
}

/**
 * The early connection, once, to whoever asks first.
 * @returns {{token: string, socket: WebSocket, events: Event[]} | null} with what came so far, which is the taker's to handle
 */
export function takeEarly() {
  const taken = early;
  early = null;
  return taken;
}
