// Parts that the plots of the live page and of recordings share: panes, their plots, ranges of axes, and how ticks are written.

import uPlot from 'uplot';

const LEFT = 58;  // [px] beside a plot: the same for all, so that their times stand one above the other
const RIGHT = 42;
const NICE = [1, 1.5, 2, 3, 4, 5, 6, 8, 10];

/** The smallest round number that is not below `value`. */
function roundUp(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * (NICE.find((digit) => digit * power >= value * (1 - 1e-9)) ?? 10);
}

/**
 * A range from zero, or from below it, with round ends, so that the axis is calm. What is unknown (null, NaN) does not count.
 * @param {number} least of the upper end
 */
const range = (least) => (plot, _low, _high, scale) => {
  let [low, high] = [0, least];
  plot.series.forEach((series, i) => {
    if (i === 0 || series.scale !== scale) return;
    const {data, scales: {x}} = plot;
    for (let k = 0; k < data[i].length; ++k) {
      const value = data[i][k];
      if (data[0][k] < x.min || data[0][k] > x.max || !Number.isFinite(value)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  });
  return [low < -0.02 * least ? -roundUp(-low) : 0, roundUp(high)];
};

/** Finds the gaps of a line, for uPlot: around values that are not known (NaN). @returns {[number, number][]} places on the canvas */
function gaps(plot, series, first, last) {
  const data = plot.data[series];
  const place = (i) => plot.valToPos(plot.data[0][Math.min(Math.max(i, first), last)], 'x', true);
  const found = [];
  for (let i = first; i <= last; ++i) {
    if (!Number.isNaN(data[i])) continue;
    const begin = i - 1;
    while (i <= last && Number.isNaN(data[i])) i += 1;
    found.push([place(begin), place(i)]);
  }
  return found;
}

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
  const room = document.createElement('div');
  room.className = 'drawing';
  pane.append(heading, legend, room);
  parent.append(pane);
  return {about, root: pane, room, legend, lines: fillLegend(legend, about.lines), plot: null};
}

/**
 * Makes the plot of a pane.
 * @param {object} pane of makePane, with `shown`: its lines @param {object} colors of the theme
 * @param {{range: () => [number, number], time: object, second?: object, sync: string, hooks: object}} how the time that is shown; the axis of
 *   time, beside its look; what has the axis at the right; plots with one `sync` have one cursor
 */
export function makePlot({about, room, shown}, colors, {range: times, time, second, sync, hooks}) {
  const axis = {
    stroke: colors.muted, font: '11px system-ui, sans-serif', grid: {stroke: colors.grid, width: 1},
    ticks: {stroke: colors.grid, width: 1, size: 4},
  };
  const scales = {x: {time: false, range: times}, y: {range: range(about.least)}};
  const axes = [{...axis, size: 26, ...time}, {...axis, size: LEFT, space: 22, values: about.tick}];
  if (second) {
    scales.second = {range: range(second.least)};
    axes.push({...axis, size: RIGHT, space: 22, values: second.tick, scale: 'second', side: 1, grid: {show: false}});
  }
  return new uPlot({
    width: Math.max(room.clientWidth, 50), height: Math.max(room.clientHeight, 40), scales, axes, legend: {show: false},
    padding: [8, second ? 0 : RIGHT, 0, 0],
    cursor: {drag: {x: false, y: false}, sync: {key: sync}, points: {show: false}, y: false},
    series: [{}, ...shown.map((line) => ({
      stroke: colors[line.color], width: line.width ?? 1.5, dash: line.dash, scale: line.scale ?? 'y', points: {show: false}, gaps,
    }))],
    hooks,
  }, [[], ...shown.map(() => [])], room);
}

/** Fits the plots to their rooms from now on. @param {object[]} panes of makePane @returns {ResizeObserver} */
export function fitPlots(panes) {
  const sizes = new ResizeObserver(() => {
    for (const {plot, room} of panes) {
      const [width, height] = [room.clientWidth, room.clientHeight];
      if (plot && width > 0 && height > 0 && (plot.width !== width || plot.height !== height)) plot.setSize({width, height});
    }
  });
  for (const {room} of panes) sizes.observe(room);
  return sizes;
}

/** Writes a text, if it is another one: each writing costs the browser a layout. */
export function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/**
 * @param {HTMLElement} legend of a pane @param {{name: string, hint: string, dash?: number[]}[]} lines of its plot
 * @returns {{mark: HTMLElement, value: HTMLElement}[]} for each line, what has its color and what has its value
 */
export function fillLegend(legend, lines) {
  legend.replaceChildren();
  return lines.map((line) => {
    const [item, mark, value] = ['span', 'i', 'b'].map((tag) => document.createElement(tag));
    item.title = line.hint;
    mark.className = line.dash ? 'dashed' : '';
    item.append(mark, `${line.name} `, value);
    legend.append(item);
    return {mark, value};
  });
}
