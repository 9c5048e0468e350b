// Histograms: how long the server's answers take and how late it wakes, from its /metrics; how late the chosen hand's servo
// wakes and how long its round trips take, from the list of sessions.

import {forSession} from './kept.js';
import {say} from './language.js';
import {TOKEN_KEY} from './socket.js';

const PERIOD = 1000;  // [ms]
const OF_SERVER = {feltwire_answer_seconds: 'times.answer', feltwire_world_late_seconds: 'times.world'};  // metric: its title
const OF_HAND = ['wakeups', 'round_trips'];

/**
 * @param {string} text what /metrics answered (Prometheus)
 * @param {string} metric the name of a histogram
 * @param {string} scene its label
 * @returns {{limit: number, count: number}[]} the longest time [s] and the count of each class; empty: there is no such histogram
 */
export function readTimes(text, metric, scene) {
  const label = scene.replace(/[\\"]/g, '\\$&').replaceAll('\n', '\\n');
  const begin = `${metric}_bucket{scene="${label}",le="`;
  let below = 0;
  return text.split('\n').filter((line) => line.startsWith(begin)).map((line) => {
    const [limit, total] = line.slice(begin.length).split('"} ');
    const count = Number(total) - below;
    below = Number(total);
    return {limit: limit === '+Inf' ? Infinity : Number(limit), count};
  });
}

/** @param {number[] | null} counts of a session @param {number[]} limits [s] of all classes but the last, of the server's hello */
const classesOf = (counts, limits) => (counts ?? []).map((count, i) => ({limit: limits[i] ?? Infinity, count}));

/** "≤ 20 µs" */
function limitText(limit, longest) {
  if (limit === Infinity) return `> ${timeText(longest)}`;
  return `≤ ${timeText(limit)}`;
}

function timeText(seconds) {
  return seconds < 1e-3 ? `${Math.round(seconds * 1e6)} µs` : `${Math.round(seconds * 1e3)} ms`;
}

export class Times {
  /**
   * @param {HTMLDialogElement} dialog what shows them, from when it is opened
   * @param {() => string} scene the name of the scene that is shown
   * @param {() => {name: string, session: object | undefined}} hand the chosen one
   */
  constructor(dialog, scene, hand) {
    this.dialog = dialog;
    this.scene = scene;
    this.hand = hand;
    this.limits = {wakeups: [], round_trips: []};
    this.begin = new Map();  // by histogram: the counts when the dialog was opened
    this.timer = null;
    dialog.addEventListener('close', () => clearInterval(this.timer));
  }

  /** @param {object} message the server's hello */
  hello(message) {
    this.limits = {wakeups: message.wakeup_limits ?? [], round_trips: message.round_trip_limits ?? []};
  }

  open() {
    this.begin.clear();
    clearInterval(this.timer);
    this.timer = setInterval(() => this.#read(), PERIOD);
    this.#read();
    if (!this.dialog.open) this.dialog.showModal();
    this.dialog.scrollTop = 0;
  }

  async #read() {
    const said = this.dialog.querySelector('p');
    try {
      const answer = await fetch('metrics', {headers: {Authorization: `Bearer ${forSession.get(TOKEN_KEY)}`}});
      if (!answer.ok) throw new Error(say('times.answered', {status: answer.status}));
      const text = await answer.text();
      this.dialog.querySelector('div').replaceChildren(...this.#ofServer(text), ...this.#ofHand());
      const missing = text.includes('feltwire_answer_seconds_bucket') ? '' : say('times.elsewhere');
      said.textContent = say('times.since') + missing;
    } catch (error) {
      said.textContent = say('times.failed', {reason: error.message});
    }
  }

  #ofServer(text) {
    const scene = this.scene();
    return Object.entries(OF_SERVER).flatMap(([metric, title]) => this.#table(`${scene} ${metric}`, say(title), readTimes(text, metric, scene)));
  }

  #ofHand() {
    const {name, session} = this.hand();
    return OF_HAND.flatMap((counts) => (
      this.#table(`${session?.session} ${counts}`, say(`times.${counts}`, {name}), classesOf(session?.[counts], this.limits[counts]))));
  }

  #table(key, title, classes) {
    if (!this.begin.has(key)) this.begin.set(key, classes);
    const begin = this.begin.get(key);
    const counts = classes.map(({count}, i) => Math.max(0, count - (begin[i]?.count ?? 0)));
    const most = Math.max(...counts, 1);
    if (classes.every(({count}) => count === 0)) return [];  // Nothing moves in this scene, say, or the client does not tell.
    const heading = document.createElement('h3');
    heading.textContent = title;
    const table = document.createElement('table');
    classes.forEach(({limit}, i) => {
      const row = table.insertRow();
      row.insertCell().textContent = limitText(limit, classes[i - 1]?.limit ?? 0);
      const bar = document.createElement('meter');
      bar.max = 1;
      bar.value = Math.log1p(counts[i]) / Math.log1p(most);
      row.insertCell().append(bar);
      row.insertCell().textContent = counts[i].toLocaleString('en');
    });
    return [heading, table];
  }
}
