// Plots of one hand of a recording, around the moment that is shown. A click goes to its moment.

import {say} from '../language.js';
import {length3} from '../messages.js';
import {imageOf} from '../plot_export.js';
import {moveByPointer} from '../plot_pointer.js';
import {energyTick, fitPlots, makePane, makePlot, put, tick} from '../plots.js';
import * as words from '../words.js';
import {rowAt} from './recording.js';
import {ACCOUNT, askedForce, FRESH, ROW} from './tables.js';

const DIGITS = 7;  // of a value in a file
const POINTS = 1200;  // of a line, at most; from where there are more, the least and the largest of each stretch are drawn

const asked = (rows, row) => askedForce(rows, row);
const size = (at) => (rows, row) => length3(rows, row + at);
const number = (at, factor = 1) => (rows, row) => factor * rows[row + at];
const hand = (segment, which) => (which === null ? segment.own : segment.hands.get(which));

/** What is plotted: a line has a name, an explanation, how a row becomes its value, a color of the theme, and how it is written. */
const PLOTS = [
  {
    title: say('plot.force'), tick: tick('N'), least: 1, table: hand, lines: [
      {name: say('line.elastic'), hint: say('line.elastic.hint'), csv: 'elastic_N', of: size(ROW.elastic), color: 'elastic', write: words.force},
      {name: say('line.friction'), hint: say('line.friction.hint'), csv: 'friction_N', of: size(ROW.friction), color: 'friction', write: words.force},
      {name: say('line.commanded'), hint: say('line.commanded.hint'), csv: 'commanded_N', of: asked, color: 'ink', dash: [5, 4], write: words.force},
      {name: say('line.held'), hint: say('line.held.hint'), csv: 'held_N', of: size(ROW.held), color: 'rendered', width: 2.5, write: words.force},
    ],
  },
  {
    title: say('plot.account'), tick: energyTick, least: 0.001, second: {tick: tick('%'), least: 5}, table: (segment, which) => (which === null ? segment.accounts : null), lines: [
      {name: say('line.balance'), hint: say('line.balance.hint'), csv: 'balance_J', of: number(ACCOUNT.balance), color: 'elastic', write: words.energy},
      {name: say('line.cut'), hint: say('line.cut.hint'), csv: 'cut_percent', of: number(ACCOUNT.cut, 100), color: 'limit', write: (value) => words.number(value, 1, '%'), scale: 'second'},
    ],
  },
  {
    title: say('plot.age'), tick: tick('ms'), least: 2, table: (segment, which) => (which === null ? segment.own : null), lines: [
      {name: say('line.age'), hint: say('line.age.hint'), csv: 'reply_age_ms', of: (rows, row) => (rows[row + ROW.age] >= 0 ? 1000 * rows[row + ROW.age] : NaN), color: 'elastic', write: (value) => words.number(value, 2, 'ms')},
    ],
  },
];

let made = 0;  // plots of recordings: each has a cursor of its own

export class ReplayPlots {
  /**
   * @param {HTMLElement} parent @param {HTMLElement} time says the time under the pointer @param {import('./recording.js').Recording} recording
   * @param {{seek: (time: number) => void, zoom: (factor: number) => void}} on
   */
  constructor(parent, time, recording, on) {
    this.recording = recording;
    this.time = 0;
    this.said = time;
    this.seconds = 5;
    this.which = null;
    this.sync = `recording-${made++}`;
    this.panes = PLOTS.map((about) => this.#makePane(about, parent, on));
    this.sizes = fitPlots(this.panes);
  }

  end() {
    this.sizes.disconnect();
    for (const {plot} of this.panes) plot?.destroy();
  }

  /** [s] that are shown: the moment is in their middle. @returns {[number, number]} */
  get range() {
    return [this.time - this.seconds / 2, this.time + this.seconds / 2];
  }

  /** @param {object} colors of the theme; makes all plots anew, since uPlot keeps its colors */
  paint(colors) {
    this.colors = colors;
    for (const pane of this.panes) {
      pane.plot?.destroy();
      pane.plot = makePlot(pane, colors, {
        range: () => this.range, second: pane.about.second, sync: this.sync,
        time: {values: (plot, ticks) => ticks.map((time) => `${+time.toFixed(3)} s`.replace('-', '−'))},
        hooks: {draw: [(plot) => drawNow(plot, this.time, colors)], setCursor: [() => this.#writeValues()]},
      });
      pane.lines.forEach(({mark}, i) => (mark.style.background = colors[pane.about.lines[i].color]));
    }
    this.show(this.time, this.which);
  }

  /** @param {number} time [s] of the recording @param {number | null} which hand of /scene/picture; null: the one that recorded */
  show(time, which) {
    this.time = time;
    this.which = which;
    const [from, to] = this.range;
    const {segments} = this.recording.segments(from, to);
    for (const pane of this.panes) {
      const {about} = pane;
      const data = linesOf(segments.map((segment) => about.table(segment, which)).filter(Boolean), about.lines, from, to);
      pane.root.hidden = data[0].length === 0 && about.table(NOTHING, which) === null;
      pane.plot?.setData(data);
      const now = rowAt(segments, (segment) => about.table(segment, which), time);
      const fresh = now && now.time >= time - FRESH;
      pane.now = about.lines.map(({of}) => (fresh ? of(now.table.rows, now.row) : null));
    }
    this.#writeValues();
  }

  /** Writes the values under the pointer and their time, or else those of the moment that is shown. */
  #writeValues() {
    const under = this.panes.find(({plot}) => plot?.cursor.idx != null)?.plot;
    const time = under?.data[0][under.cursor.idx];
    for (const pane of this.panes) {
      const at = pane.plot?.cursor.idx;
      pane.lines.forEach(({value}, i) => put(value, pane.shown[i].write(time === undefined ? pane.now?.[i] ?? null : pane.plot?.data[i + 1][at] ?? null)));
    }
    put(this.said, time === undefined ? '' : say('plot.at', {time: words.clock(time)}));
  }

  /** Points of the plots, for tests. */
  get points() {
    return this.panes.map(({plot}) => plot?.data[0].length ?? 0);
  }

  /** @returns {string} all values of the time that is shown, as CSV */
  csv() {
    const [from, to] = this.range;
    const {segments} = this.recording.segments(from, to);
    const lines = this.panes.flatMap(({about}) => about.lines.map((line) => ({...line, table: about.table})));
    const rows = new Map();  // time -> values: messages of one tick have one time
    lines.forEach(({of, table}, column) => {
      for (const {table: {times, rows: values, width}, first, last} of partsOf(segments.map((segment) => table(segment, this.which)).filter(Boolean), from, to)) {
        for (let i = first; i <= last; ++i) {
          if (!rows.has(times[i])) rows.set(times[i], lines.map(() => ''));
          const value = of(values, i * width);
          if (Number.isFinite(value)) rows.get(times[i])[column] = +value.toPrecision(DIGITS);
        }
      }
    });
    const written = [...rows].sort(([a], [b]) => a - b).map(([time, values]) => [time.toFixed(6), ...values].join());
    return `${[['time_s', ...lines.map(({csv}) => csv)].join(), ...written].join('\n')}\n`;
  }

  /** @param {string} title @returns {HTMLCanvasElement} all plots */
  image(title) {
    return imageOf(this.panes.filter(({root}) => !root.hidden), title, this.colors);
  }

  #makePane(about, parent, on) {
    const pane = makePane(about, parent);
    pane.shown = about.lines;
    let dragged = false;
    moveByPointer(pane.room, {
      zoom: (factor) => on.zoom(factor),
      move: (share) => {
        dragged = true;
        on.seek(this.time + share * this.seconds);
      },
      area: () => pane.plot.over,
    });
    pane.room.addEventListener('pointerdown', () => (dragged = false));
    pane.room.onclick = (event) => {
      if (dragged) return;
      const area = pane.plot.over.getBoundingClientRect();
      on.seek(pane.plot.posToVal(event.clientX - area.left, 'x'));
    };
    return pane;
  }
}

const NOTHING = {own: {}, accounts: {}, hands: new Map()};

/** A line at the moment that is shown. */
function drawNow(plot, time, colors) {
  const x = Math.round(plot.valToPos(time, 'x', true)) + 0.5;
  const {ctx, bbox} = plot;
  ctx.save();
  ctx.strokeStyle = colors.ink;
  ctx.lineWidth = devicePixelRatio;
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  ctx.restore();
}

/** Which rows of each table are between two times. */
function partsOf(tables, from, to) {
  return tables.map((table) => ({table, first: table.before(from) + 1, last: table.before(to)})).filter(({first, last}) => last >= first);
}

/** Rows between two times as columns. Of many rows, each stretch has two points: the least and the largest value, in their order. */
function linesOf(tables, lines, from, to) {
  const parts = partsOf(tables, from, to);
  const count = parts.reduce((sum, {first, last}) => sum + last - first + 1, 0);
  const stride = Math.max(1, Math.ceil((2 * count) / POINTS));
  const columns = [[], ...lines.map(() => [])];
  for (const {table, first, last} of parts) {
    for (let i = first; i <= last; i += stride) {
      const end = Math.min(i + stride - 1, last);
      columns[0].push(table.times[i]);
      if (end > i) columns[0].push(table.times[end]);
      lines.forEach(({of}, k) => pushStretch(columns[k + 1], table, of, i, end));
    }
  }
  return columns;
}

function pushStretch(column, table, of, first, last) {
  let [low, high] = [first, first];
  let [least, largest] = [Infinity, -Infinity];
  for (let i = first; i <= last; ++i) {
    const value = of(table.rows, i * table.width);
    if (value < least) [low, least] = [i, value];
    if (value > largest) [high, largest] = [i, value];
  }
  const known = (value) => (Number.isFinite(value) ? value : null);
  if (first === last) column.push(known(least));
  else column.push(known(low <= high ? least : largest), known(low <= high ? largest : least));
}
