// The WebSocket to the server: the token, the state in words, and new attempts with growing pauses.

import {takeEarly} from './early.js';
import {forSession} from './kept.js';
import {say} from './language.js';
import {openSocket, takeToken, TOKEN_KEY} from './socket.js';

const FIRST_PAUSE = 0.5;  // [s]
const LONGEST_PAUSE = 10;  // [s]
const SILENCE = 3;  // [s] without any message before the page says so

const CLOSED = [1001, 4400, 4401, 4429];  // codes that have a text

/**
 * Keeps one connection up.
 * States: `token` (one is asked for), `connecting`, `live`, `silent` (no message for some seconds), `waiting` (for the next attempt),
 * `ended` (for good).
 */
export class Connection {
  /**
   * @param {{text: (message: object) => void, binary: (buffer: ArrayBuffer) => void,
   *          state: (state: string, words: string) => void}} on what to call
   */
  constructor(on) {
    this.on = on;
    this.state = 'connecting';
    this.attempts = 0;
    this.nextAttempt = 0;
    this.reason = '';
    this.heard = 0;
    this.socket = null;
    setInterval(() => this.#tick(), 250);
    addEventListener('hashchange', () => {
      if (this.state !== 'ended' && takeToken()) this.connect();
    });
  }

  /** Connects, or asks for a token if there is none. */
  connect() {
    const early = takeEarly();
    if (early) forSession.set(TOKEN_KEY, early.token);  // Where the browser keeps nothing, only early.js has it.
    const token = takeToken();
    this.socket?.close();
    this.socket = null;
    if (!token) {
      this.#become('token', say('link.token'));
      return;
    }
    this.#become('connecting', say('link.connecting'));
    const {socket, events} = early?.token === token ? early : {socket: openSocket(token), events: []};
    if (early && early.socket !== socket) early.socket.close();
    this.socket = socket;
    socket.onmessage = (event) => socket === this.socket && this.#message(event.data);
    socket.onclose = (event) => socket === this.socket && this.#closed(event);
    for (const event of events) (event.type === 'message' ? socket.onmessage : socket.onclose)(event);
  }

  /** @param {string} token what the user typed */
  useToken(token) {
    forSession.set(TOKEN_KEY, token);
    this.attempts = 0;
    this.connect();
  }

  /** Ends the connection for good. @param {string} words what is said of it */
  end(words) {
    const {socket} = this;
    this.socket = null;
    socket?.close();
    this.#become('ended', words);
  }

  /** @param {object} message sent if the connection stands */
  send(message) {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  #message(data) {
    this.heard = performance.now();
    if (typeof data !== 'string') {
      this.on.binary(data);
      return;
    }
    let message;
    try {
      message = JSON.parse(data);
    } catch {
      return;  // A later server may send what this page does not know.
    }
    if (message?.type === 'hello') {
      this.attempts = 0;
      this.#become('live', say('link.live'));
    }
    if (message) this.on.text(message);
  }

  #closed(event) {
    this.socket = null;
    const known = this.state === 'live' || this.state === 'silent' ? 'link.lost' : 'link.unanswered';
    const words = say(CLOSED.includes(event.code) ? `link.closed.${event.code}` : known);
    this.reason = event.reason ? `${words} (${event.reason})` : words;
    if (event.code === 4401) {
      forSession.remove(TOKEN_KEY);
      this.#become('token', this.reason);
      return;
    }
    const pause = Math.min(FIRST_PAUSE * 2 ** this.attempts, LONGEST_PAUSE) * (1 + 0.2 * Math.random());
    this.attempts += 1;
    this.nextAttempt = performance.now() + 1000 * pause;
    this.#waiting();
  }

  #waiting() {
    const left = Math.max(0, Math.ceil((this.nextAttempt - performance.now()) / 1000));
    this.#become('waiting', say('link.attempt', {reason: this.reason, seconds: left}));
  }

  #tick() {
    const now = performance.now();
    if (this.state === 'waiting') {
      if (now >= this.nextAttempt) this.connect();
      else this.#waiting();
    }
    const quiet = (now - this.heard) / 1000;
    if ((this.state === 'live' || this.state === 'silent') && quiet > SILENCE) {
      this.#become('silent', say('link.silent', {seconds: Math.floor(quiet)}));
    } else if (this.state === 'silent') {
      this.#become('live', say('link.live'));
    }
  }

  #become(state, words) {
    this.state = state;
    this.on.state(state, words);
  }
}
