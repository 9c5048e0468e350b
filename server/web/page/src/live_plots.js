// Plots of the chosen hand, or of several hands over each other. Time runs to the right. It ends now, until the user zooms or moves it.

import {COLUMN} from './hands.js';
import {say} from './language.js';
import {csvOf, imageOf} from './plot_export.js';
import {energyTick, fillLegend, fitPlots, makePane, makePlot, put, tick} from './plots.js';
import {moveByPointer} from './plot_pointer.js';
import {TimeWindow} from './time_window.js';
import * as words from './words.js';

const MOST = 8;  // hands over each other
const STEPS = 5;  // between ticks of time, about
const ZOOM = 1.5;  // of a key
const MOVE = 0.2;  // share of the window that a key moves it

/**
 * All plots. A line has a name, an explanation, a column, a color of the theme, and how its value is written. `compared` is the line that is
 * shown of several hands.
 */
const PLOTS = [
  {
    title: say('plot.force'), tick: tick('N'), least: 1, compared: 3, lines: [
      {name: say('line.elastic'), hint: say('line.elastic.hint'), column: COLUMN.elastic, color: 'elastic', write: words.force},
      {name: say('line.friction'), hint: say('line.friction.hint'), column: COLUMN.friction, color: 'friction', write: words.force},
      {name: say('line.commanded'), hint: say('line.commanded.hint'), column: COLUMN.commanded, color: 'ink', dash: [5, 4], write: words.force},
      {name: say('line.rendered'), hint: say('line.rendered.hint'), column: COLUMN.rendered, color: 'rendered', width: 2.5, write: words.force},
    ],
  },
  {
    title: say('plot.depth'), tick: tick('mm'), least: 1, compared: 0, lines: [
      {name: say('line.depth'), hint: say('line.depth.hint'), column: COLUMN.depth, color: 'ink', write: (value) => words.number(value, 2, 'mm')},
    ],
  },
  {
    title: say('plot.energy'), tick: energyTick, least: 0.001, compared: 0, lines: [
      {name: say('line.given'), hint: say('line.given.hint'), column: COLUMN.given, color: 'elastic', write: words.energy},
      {name: say('line.allowed'), hint: say('line.allowed.hint'), column: COLUMN.ceiling, color: 'limit', dash: [5, 4], write: words.energy},
      {name: say('line.burned'), hint: say('line.burned.hint'), column: COLUMN.burned, color: 'friction', write: words.energy},
    ],
  },
  {
    title: say('plot.network'), tick: tick('ms'), least: 2, compared: 0, second: {tick: tick('%'), least: 5}, lines: [
      {name: say('line.trip'), hint: say('column.trip.hint'), column: COLUMN.roundTrip, color: 'elastic', write: (value) => words.number(value, 2, 'ms')},
      {name: say('line.loss'), hint: say('column.loss.hint'), column: COLUMN.loss, color: 'friction', write: (value) => words.number(value, 1, '%'), scale: 'second'},
    ],
  },
];

/** @typedef {{number: number, name: string, history: import('./history.js').History}} Shown a hand that is plotted */

export class Plots {
  /** @param {HTMLElement} parent @param {HTMLElement} time says the time under the pointer @param {() => void} hold called when the user zooms or moves the time */
  constructor(parent, time, hold) {
    this.window = new TimeWindow();
    this.time = time;
    this.hold = hold;
    this.colors = null;
    this.shown = [];  // the chosen hand first
    this.comparing = false;
    this.layout = '';  // of the lines
    this.tints = new Map();  // number of a hand that is compared -> its color
    this.points = 0;
    this.begun = false;
    this.panes = PLOTS.map((plot) => makePane(plot, parent));
    for (const pane of this.panes) {
      pane.shown = pane.about.lines;
      moveByPointer(pane.room, {
        zoom: (factor, share) => this.#change((end) => this.window.zoom(factor, this.#timeAt(pane, share), end)),
        move: (share) => this.#change((end) => this.window.move(share * this.#span(), end)),
        area: () => pane.plot?.over ?? pane.room,
      });
    }
    fitPlots(this.panes);
  }

  /** Time of the newest values [s]. */
  get end() {
    return this.shown[0]?.history.end ?? 0;
  }

  /** @param {object} colors of the theme; makes all plots anew, since uPlot keeps its colors */
  paint(colors) {
    this.colors = colors;
    this.layout = '';
    this.update();
  }

  /** Makes the plots, unless they are made. Until then there are their titles only: the first picture does not wait for them. */
  begin() {
    if (this.begun) return;
    this.begun = true;
    this.layout = '';
    this.update();
  }

  /** @param {1 | -1} step in or out, about the middle */
  zoom(step) {
    this.#change((end) => this.window.zoom(ZOOM ** step, this.window.range(end).reduce((sum, time) => sum + time / 2, 0), end));
  }

  /** @param {1 | -1} step later or earlier */
  move(step) {
    this.#change((end) => this.window.move(step * MOVE * this.#span(), end));
  }

  /** The time ends now again. @param {number} [seconds] that are shown */
  follow(seconds = this.window.seconds) {
    this.window.seconds = seconds;
    this.window.follow();
    this.update();
  }

  /** @param {Shown[]} [hands] the chosen one first; without: those of the last call */
  update(hands = this.shown) {
    this.shown = hands.slice(0, this.comparing ? MOST : 1);
    this.#arrange();
    const base = this.shown.reduce((long, {history}) => (history.size > (long?.size ?? 0) ? history : long), null);
    const [from, to] = this.window.range(this.end);
    const first = Math.max((base?.at(from) ?? 0) - 1, 0);
    const last = Math.min((base?.at(to) ?? -1) + 1, base?.size ?? 0);
    this.points = last - first;
    const times = base?.columns[0].subarray(first, last) ?? [];
    for (const pane of this.panes) {
      pane.plot?.setData([times, ...pane.shown.map(({column, hand}) => part((this.shown[hand ?? 0])?.history, column, base, first, last))]);
    }
    this.writeValues();
  }

  /** Writes the values under the pointer and their time, or else the newest. */
  writeValues() {
    const under = this.panes.find(({plot}) => plot?.cursor.idx != null)?.plot;
    const at = under?.cursor.idx ?? this.points - 1;
    for (const pane of this.panes) {
      pane.lines.forEach(({value}, i) => {
        const data = pane.plot?.data[i + 1];
        put(value, pane.shown[i].write(data && at >= 0 ? data[at] : null));
      });
    }
    put(this.time, under ? say('plot.at', {time: this.#timeText(under.data[0][at], 2)}) : '');
  }

  /** @returns {string} the values that are shown, as CSV */
  csv() {
    return csvOf(this.shown, this.window.range(this.end));
  }

  /** @param {string} title @returns {HTMLCanvasElement} all plots */
  image(title) {
    return imageOf(this.panes, title, this.colors);
  }

  /** Another time is shown from now on. @param {(end: number) => void} act */
  #change(act) {
    this.hold();
    act(this.end);
    this.update();
  }

  #span() {
    const [from, to] = this.window.range(this.end);
    return to - from;
  }

  #timeAt(pane, share) {
    const [from, to] = this.window.range(this.end);
    return from + share * (to - from);
  }

  /** Makes lines and legends anew, if others are wanted. */
  #arrange() {
    const compared = this.comparing ? this.shown.map(({number, name}) => `${number} ${name}`).join('\n') : 'one';
    if (!this.colors || this.layout === compared) return;
    this.layout = compared;
    this.#tint();
    for (const pane of this.panes) {
      const {about} = pane;
      const line = about.lines[about.compared];
      pane.shown = this.comparing ? this.shown.map(({number, name}, hand) => ({
        ...line, name: words.middle(name, 16), hint: say('hand.number', {number}), hand, color: this.tints.get(number), dash: undefined, width: hand === 0 ? 2.5 : 1.5,
      })) : about.lines;
      pane.root.querySelector('h3').textContent = this.comparing && about.lines.length > 1 ? say('line.compared', {title: about.title, line: line.name}) : about.title;
      pane.lines = fillLegend(pane.legend, pane.shown);
      pane.lines.forEach(({mark}, i) => (mark.style.background = this.colors[pane.shown[i].color]));
      pane.plot?.destroy();
      pane.plot = this.begun ? this.#makePlot(pane) : null;
    }
  }

  /** A hand keeps its color as long as it is compared. */
  #tint() {
    for (const number of this.tints.keys()) if (!this.shown.some((hand) => hand.number === number)) this.tints.delete(number);
    for (const {number} of this.shown) {
      const taken = [...this.tints.values()];
      const free = Array.from({length: MOST}, (_, i) => `hand${i + 1}`).find((color) => !taken.includes(color));
      if (!this.tints.has(number)) this.tints.set(number, free);
    }
  }

  #makePlot(pane) {
    return makePlot(pane, this.colors, {
      range: () => this.window.range(this.end), second: this.comparing ? null : pane.about.second, sync: 'feltwire',
      time: {splits: () => this.#timeTicks(), values: (plot, ticks) => ticks.map((time) => this.#timeText(time, 3))},
      hooks: {setCursor: [() => this.writeValues()]},
    });
  }

  #timeTicks() {
    const {end} = this;
    const [from, to] = this.window.range(end);
    const step = words.roundDown((to - from) / STEPS);
    const [first, last] = [Math.ceil((from - end) / step - 1e-6), Math.floor((to - end) / step + 1e-6)];
    return Array.from({length: Math.max(last - first + 1, 0)}, (_, i) => end + (first + i) * step);
  }

  /** @param {number} time [s] @returns {string} how long ago that was */
  #timeText(time, digits) {
    const ago = +(this.end - time).toFixed(digits);
    return ago === 0 ? say('plot.now') : `${ago > 0 ? '−' : '+'}${Math.abs(ago)} s`;
  }
}

/** Values of a hand beside the times of the longest history: pictures have all hands, so histories end together. */
function part(history, column, base, first, last) {
  if (!history || !base) return [];
  const before = base.size - history.size;
  if (first >= before) return history.columns[column].subarray(first - before, last - before);
  const values = new Float64Array(last - first).fill(NaN);
  if (last > before) values.set(history.columns[column].subarray(0, last - before), before - first);
  return values;
}
