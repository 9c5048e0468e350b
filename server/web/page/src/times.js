// How long the server's answers take, and how late it wakes for what moves: the histograms of its /metrics.

import {TOKEN_KEY} from './socket.js';

const PERIOD = 1000;  // [ms]
const TITLES = {
  feltwire_answer_seconds: 'From when the server took a datagram up to its answer',
  feltwire_world_late_seconds: 'How late the server woke for what moves',
};

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
   */
  constructor(dialog, scene) {
    this.dialog = dialog;
    this.scene = scene;
    this.begin = new Map();  // by metric: the counts when the dialog was opened
    this.timer = null;
    dialog.addEventListener('close', () => clearInterval(this.timer));
  }

  open() {
    this.begin.clear();
    clearInterval(this.timer);
    this.timer = setInterval(() => this.#read(), PERIOD);
    this.#read();
    if (!this.dialog.open) this.dialog.showModal();
  }

  async #read() {
    const said = this.dialog.querySelector('p');
    try {
      const answer = await fetch('metrics', {headers: {Authorization: `Bearer ${sessionStorage.getItem(TOKEN_KEY)}`}});
      if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
      const text = await answer.text();
      this.dialog.querySelector('div').replaceChildren(...Object.entries(TITLES).flatMap(([metric, title]) => this.#table(text, metric, title)));
      said.textContent = 'Since this was opened. The bars are logarithmic.';
    } catch (error) {
      said.textContent = `The times cannot be read: ${error.message}.`;
    }
  }

  #table(text, metric, title) {
    const classes = readTimes(text, metric, this.scene());
    if (!this.begin.has(metric)) this.begin.set(metric, classes);
    const begin = this.begin.get(metric);
    const counts = classes.map(({count}, i) => Math.max(0, count - (begin[i]?.count ?? 0)));
    const most = Math.max(...counts, 1);
    if (classes.length === 0 || classes.every(({count}) => count === 0)) return [];  // Nothing moves in this scene, say.
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
