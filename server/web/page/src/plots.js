// Plots of the chosen hand. Time runs to the right and ends now.

import uPlot from 'uplot';
import {COLUMN} from './hands.js';
import * as words from './words.js';

const LEFT = 58;  // pixels beside a plot: the same for all, so that their times stand one above the other
const RIGHT = 42;
const NICE = [1, 1.5, 2, 3, 4, 5, 6, 8, 10];

/** The smallest round number that is not below `value`. */
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * (NICE.find((digit) => digit * power >= value * (1 - 1e-9)) ?? 10);
}

/** A range from zero, or from below it, with round ends, so that the axis is calm. @param {number} least of the upper end */
export const range = (least) => (plot, low, high) => {
  const top = Number.isFinite(high) ? Math.max(high, least) : least;
  return [Number.isFinite(low) && low < -0.02 * least ? -roundUp(-low) : 0, roundUp(top)];
};

export const tick = (unit) => (plot, ticks) => ticks.map((value) => `${+value.toPrecision(4)} ${unit}`.replace('-', '−'));
export const energyTick = (plot, ticks) => {
  const small = Math.max(...ticks.map(Math.abs)) < 1;
  return tick(small ? 'mJ' : 'J')(plot, small ? ticks.map((value) => 1000 * value) : ticks);
};

/**
 * Adds the place of a plot: its title, its legend and the room that it is drawn in.
 * @param {object} about what is plotted, with `title` and `lines` @param {HTMLElement} parent
 */
export function makePane(about, parent) {
  const pane = document.createElement('section');
  pane.className = 'plot';
  const heading = document.createElement('h3');
  heading.textContent = about.title;
  const legend = document.createElement('p');
  legend.className = 'legend';
  const lines = about.lines.map((line) => {
    const [item, mark, value] = ['span', 'i', 'b'].map((tag) => document.createElement(tag));
    item.title = line.hint;
    mark.className = line.dash ? 'dashed' : '';
    item.append(mark, `${line.name} `, value);
    legend.append(item);
    return {mark, value};
  });
  const room = document.createElement('div');
  room.className = 'drawing';
  pane.append(heading, legend, room);
  parent.append(pane);
  return {about, root: pane, room, lines, plot: null};
}

/** What is plotted: a line has a name, an explanation, a column, a color of the theme, and how its value is written. */
const PLOTS = [
  {
    title: 'Force', tick: tick('N'), least: 1, lines: [
      {name: 'elastic', hint: 'commanded by the scene, against the surface\'s deformation', column: COLUMN.elastic, color: 'elastic', write: words.force},
      {name: 'friction', hint: 'commanded by the scene, against sliding', column: COLUMN.friction, color: 'friction', write: words.force},
      {name: 'commanded', hint: 'size of the sum of both, which the scene asks for', column: COLUMN.commanded, color: 'ink', dash: [5, 4], write: words.force},
      {name: 'rendered', hint: 'what the device holds after all limits', column: COLUMN.rendered, color: 'rendered', width: 2.5, write: words.force},
    ],
  },
  {
    title: 'Depth in the surface', tick: tick('mm'), least: 1, lines: [
      {name: 'depth', hint: 'of the tool in the surface', column: COLUMN.depth, color: 'ink', write: (value) => words.number(value, 2, 'mm')},
    ],
  },
  {
    title: 'Energy', tick: energyTick, least: 0.001, lines: [
      {name: 'delivered', hint: 'to the hand; negative: the hand gave', column: COLUMN.delivered, color: 'elastic', write: words.energy},
      {name: 'allowed', hint: 'delivered, and the room that the energy account has left', column: COLUMN.ceiling, color: 'limit', dash: [5, 4], write: words.energy},
      {name: 'burned', hint: 'by the device, for certain', column: COLUMN.burned, color: 'friction', write: words.energy},
    ],
  },
  {
    title: 'Network', tick: tick('ms'), least: 2, second: {tick: tick('%'), least: 5}, lines: [
      {name: 'round trip', hint: 'of a sample and its reply', column: COLUMN.roundTrip, color: 'elastic', write: (value) => words.number(value, 2, 'ms')},
      {name: 'loss', hint: 'of datagrams', column: COLUMN.loss, color: 'friction', write: (value) => words.number(value, 1, '%'), scale: 'second'},
    ],
  },
];

export class Plots {
  /** @param {HTMLElement} parent */
  constructor(parent) {
    this.seconds = 10;
    this.end = 0;
    this.colors = null;
    this.history = null;
    this.points = 0;
    this.begun = false;
    this.panes = PLOTS.map((plot) => makePane(plot, parent));
    const sizes = new ResizeObserver(() => this.#resize());
    for (const pane of this.panes) sizes.observe(pane.room);
  }

  /** @param {object} colors of the theme; makes all plots anew, since uPlot keeps its colors */
  paint(colors) {
    this.colors = colors;
    for (const pane of this.panes) {
      if (this.begun) this.#makeAnew(pane);
      pane.lines.forEach(({mark}, i) => (mark.style.background = colors[pane.about.lines[i].color]));
    }
    this.update(this.history);
  }

  /** Makes the plots, unless they are made. Until then there are their titles only: the first picture does not wait for them. */
  begin() {
    if (this.begun) return;
    this.begun = true;
    for (const pane of this.panes) this.#makeAnew(pane);
    this.update(this.history);
  }

  /** @param {import('./history.js').History | null} history of the chosen hand */
  update(history) {
    this.history = history;
    const first = history?.since(this.seconds) ?? 0;
    const size = history?.size ?? 0;
    const column = (i) => history?.columns[i].subarray(first, size) ?? [];
    const times = column(0);
    this.points = times.length;
    this.end = size > 0 ? times[times.length - 1] : 0;
    for (const pane of this.panes) {
      pane.plot?.setData([times, ...pane.about.lines.map((line) => column(line.column))]);
    }
  }

  /** Writes the values under the pointer, or else the newest. */
  writeValues() {
    for (const pane of this.panes) {
      const under = pane.plot?.cursor.idx;
      const at = under ?? this.points - 1;
      pane.lines.forEach(({value}, i) => {
        const data = pane.plot?.data[i + 1];
        const text = pane.about.lines[i].write(data && at >= 0 ? data[at] : null);
        if (value.textContent !== text) value.textContent = text;
      });
    }
  }

  #makeAnew(pane) {
    pane.plot?.destroy();
    pane.plot = this.#makePlot(pane);
  }

  #makePlot({about, room}) {
    const {colors} = this;
    const axis = {
      stroke: colors.muted, font: '11px system-ui, sans-serif', grid: {stroke: colors.grid, width: 1},
      ticks: {stroke: colors.grid, width: 1, size: 4},
    };
    const scales = {x: {time: false, range: () => [this.end - this.seconds, this.end]}, y: {range: range(about.least)}};
    const axes = [
      {
        ...axis, size: 26, splits: () => this.#timeTicks(),
        values: (plot, ticks) => ticks.map((time) => (Math.abs(time - this.end) < 1e-6 ? 'now' : `−${Math.round(this.end - time)} s`)),
      },
      {...axis, size: LEFT, space: 22, values: about.tick},
    ];
    if (about.second) {
      scales.second = {range: range(about.second.least)};
      axes.push({...axis, size: RIGHT, space: 22, values: about.second.tick, scale: 'second', side: 1, grid: {show: false}});
    }
    const options = {
      width: Math.max(room.clientWidth, 50), height: Math.max(room.clientHeight, 40), scales, axes, legend: {show: false},
      padding: [8, about.second ? 0 : RIGHT, 0, 0],
      cursor: {drag: {x: false, y: false}, sync: {key: 'feltwire'}, points: {show: false}, y: false},
      series: [{}, ...about.lines.map((line) => ({
        stroke: colors[line.color], width: line.width ?? 1.5, dash: line.dash, scale: line.scale ?? 'y', points: {show: false},
      }))],
    };
    return new uPlot(options, [[], ...about.lines.map(() => [])], room);
  }

  #timeTicks() {
    const step = this.seconds / 5;
    return Array.from({length: 6}, (_, i) => this.end - (5 - i) * step);
  }

  #resize() {
    for (const {plot, room} of this.panes) {
      const [width, height] = [room.clientWidth, room.clientHeight];
      if (plot && width > 0 && height > 0 && (plot.width !== width || plot.height !== height)) plot.setSize({width, height});
    }
  }
}
