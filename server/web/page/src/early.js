// Opens the connection before the rest of the script runs: the server's first messages travel while the 3D view is made. main.js imports
// it first; modules run in the order of imports.

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
