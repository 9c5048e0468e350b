// The token of the page, and the WebSocket that it opens.

import {forSession} from './kept.js';

export const TOKEN_KEY = 'feltwire-token';  // of the session's storage

/** Moves a token from the URL's fragment to the session's storage, so that it stays in no history and no screenshot. The rest stays. */
export function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get('token');
  if (given) {
    forSession.set(TOKEN_KEY, given);
    const rest = location.hash.slice(1).split('&').filter((part) => !part.startsWith('token=')).join('&');
    history.replaceState(null, '', location.pathname + location.search + (rest && `#${rest}`));
  }
  return forSession.get(TOKEN_KEY);
}

/** The address of a WebSocket beside the page, also where a proxy serves the page in a folder. @param {string} path relative @returns {string} */
export function socketAddress(path) {
  const address = new URL(path, location.href);
  address.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
  return address.href;
}

/** A WebSocket to the server that sends the token as its first message. @param {string} token @returns {WebSocket} */
export function openSocket(token) {
  const socket = new WebSocket(socketAddress('live'), 'feltwire.live.v1');
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => socket.send(JSON.stringify({token}));
  return socket;
}
