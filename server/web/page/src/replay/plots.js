// Plots of one hand of a recording, around the moment that is shown. A click goes to its moment.

import uPlot from 'uplot';
import {say} from '../language.js';
import {length3} from '../messages.js';
import {energyTick, LEFT, makePane, range, RIGHT, tick} from '../plots.js';
import * as words from '../words.js';
import {rowAt} from './recording.js';
import {ACCOUNT, askedForce, FRESH, ROW} from './tables.js';

const POINTS = 1200;  // of a line, at most; from where there are more, the least and the largest of each stretch are drawn

const asked = (rows, row) => askedForce(rows, row);
const size = (at) => (rows, row) => length3(rows, row + at);
const number = (at, factor = 1) => (rows, row) => factor * rows[row + at];
const hand = (segment, which) => (which === null ? segment.own : segment.hands.get(which));

/** What is plotted: a line has a name, an explanation, how a row becomes its value, a color of the theme, and how it is written. */
const PLOTS = [
  {
    title: say('plot.force'), tick: tick('N'), least: 1, table: hand, lines: [
      {name: say('line.elastic'), hint: say('line.elastic.hint'), of: size(ROW.elastic), color: 'elastic', write: words.force},
      {name: say('line.friction'), hint: say('line.friction.hint'), of: size(ROW.friction), color: 'friction', write: words.force},
      {name: say('line.commanded'), hint: say('line.commanded.hint'), of: asked, color: 'ink', dash: [5, 4], write: words.force},
      {name: say('line.held'), hint: say('line.held.hint'), of: size(ROW.held), color: 'rendered', width: 2.5, write: words.force},
    ],
  },
  {
    title: say('plot.account'), tick: energyTick, least: 0.001, second: {tick: tick('%'), least: 5}, table: (segment, which) => (which === null ? segment.accounts : null), lines: [
      {name: say('line.balance'), hint: say('line.balance.hint'), of: number(ACCOUNT.balance), color: 'elastic', write: words.energy},
      {name: say('line.cut'), hint: say('line.cut.hint'), of: number(ACCOUNT.cut, 100), color: 'limit', write: (value) => words.number(value, 1, '%'), scale: 'second'},
    ],
  },
  {
    title: say('plot.age'), tick: tick('ms'), least: 2, table: (segment, which) => (which === null ? segment.own : null), lines: [
      {name: say('line.age'), hint: say('line.age.hint'), of: (rows, row) => (rows[row + ROW.age] >= 0 ? 1000 * rows[row + ROW.age] : NaN), color: 'elastic', write: (value) => words.number(value, 2, 'ms')},
    ],
  },
];

export class ReplayPlots {
  /** @param {HTMLElement} parent @param {import('./recording.js').Recording} recording @param {(time: number) => void} seek */
  constructor(parent, recording, seek) {
    this.recording = recording;
    this.seek = seek;
    this.seconds = 5;
    this.time = 0;
    this.which = null;
    this.panes = PLOTS.map((about) => this.#makePane(about, parent));
    this.sizes = new ResizeObserver(() => this.#resize());
    for (const pane of this.panes) this.sizes.observe(pane.room);
  }

  end() {
    this.sizes.disconnect();
    for (const {plot} of this.panes) plot?.destroy();
  }

  /** @param {object} colors of the theme; makes all plots anew, since uPlot keeps its colors */
  paint(colors) {
    for (const pane of this.panes) {
      pane.plot?.destroy();
      pane.plot = this.#makePlot(pane, colors);
      pane.lines.forEach(({mark}, i) => (mark.style.background = colors[pane.about.lines[i].color]));
    }
    this.show(this.time, this.which);
  }

  /** @param {number} time [s] of the recording @param {number | null} which hand of /scene/picture; null: the one that recorded */
  show(time, which) {
    this.time = time;
    this.which = which;
    const [from, to] = [time - this.seconds / 2, time + this.seconds / 2];
    const {segments} = this.recording.segments(from, to);
    for (const pane of this.panes) {
      const {about} = pane;
      const data = linesOf(segments.map((segment) => about.table(segment, which)).filter(Boolean), about.lines, from, to);
      pane.root.hidden = data[0].length === 0 && about.table(NOTHING, which) === null;
      pane.plot?.setData(data);
      const now = rowAt(segments, (segment) => about.table(segment, which), time);
      const fresh = now && now.time >= time - FRESH;
      pane.lines.forEach(({value}, i) => {
        const text = about.lines[i].write(fresh ? about.lines[i].of(now.table.rows, now.row) : null);
        if (value.textContent !== text) value.textContent = text;
      });
    }
  }

  /** Points of the plots, for tests. */
  get points() {
    return this.panes.map(({plot}) => plot?.data[0].length ?? 0);
  }

  #makePane(about, parent) {
    const pane = makePane(about, parent);
    pane.room.onclick = (event) => {
      const {plot} = pane;
      const area = plot.over.getBoundingClientRect();
      this.seek(plot.posToVal(event.clientX - area.left, 'x'));
    };
    return pane;
  }

  #makePlot({about, room}, colors) {
    const axis = {
      stroke: colors.muted, font: '11px system-ui, sans-serif', grid: {stroke: colors.grid, width: 1},
      ticks: {stroke: colors.grid, width: 1, size: 4},
    };
    const scales = {x: {time: false, range: () => [this.time - this.seconds / 2, this.time + this.seconds / 2]}, y: {range: range(about.least)}};
    const axes = [
      {...axis, size: 26, values: (plot, ticks) => ticks.map((time) => `${+time.toFixed(3)} s`.replace('-', '−'))},
      {...axis, size: LEFT, space: 22, values: about.tick},
    ];
    if (about.second) {
      scales.second = {range: range(about.second.least)};
      axes.push({...axis, size: RIGHT, space: 22, values: about.second.tick, scale: 'second', side: 1, grid: {show: false}});
    }
    const options = {
      width: Math.max(room.clientWidth, 50), height: Math.max(room.clientHeight, 40), scales, axes, legend: {show: false},
      padding: [8, about.second ? 0 : RIGHT, 0, 0], cursor: {drag: {x: false, y: false}, points: {show: false}, y: false},
      series: [{}, ...about.lines.map((line) => ({
        stroke: colors[line.color], width: line.width ?? 1.5, dash: line.dash, scale: line.scale ?? 'y', points: {show: false},
      }))],
      hooks: {draw: [(plot) => drawNow(plot, this.time, colors)]},
    };
    return new uPlot(options, [[], ...about.lines.map(() => [])], room);
  }

  #resize() {
    for (const {plot, room} of this.panes) {
      const [width, height] = [room.clientWidth, room.clientHeight];
      if (plot && width > 0 && height > 0 && (plot.width !== width || plot.height !== height)) plot.setSize({width, height});
    }
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

/** Rows between two times as columns. Of many rows, each stretch has two points: the least and the largest value, in their order. */
function linesOf(tables, lines, from, to) {
  const parts = tables.map((table) => ({table, first: table.before(from) + 1, last: table.before(to)})).filter(({first, last}) => last >= first);
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
