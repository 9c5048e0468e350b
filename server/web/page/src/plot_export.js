// Plots as files: the values as CSV, the drawings as an image.

import {COLUMN} from './hands.js';

/** Columns of the file, after time, hand and client. */
const COLUMNS = [
  ['elastic_N', COLUMN.elastic], ['friction_N', COLUMN.friction], ['commanded_N', COLUMN.commanded], ['rendered_N', COLUMN.rendered],
  ['depth_mm', COLUMN.depth], ['energy_given_J', COLUMN.given], ['energy_allowed_J', COLUMN.ceiling], ['energy_burned_J', COLUMN.burned],
  ['round_trip_ms', COLUMN.roundTrip], ['loss_percent', COLUMN.loss],
];
const DIGITS = 7;  // what a value of the page has
const TITLE = 30;  // [px]
const LEGEND = 40;  // [px] title and legend of a plot
const FONT = 'system-ui, sans-serif';

const quoted = (text) => (/[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);

/** @param {import('./live_plots.js').Shown[]} hands @param {[number, number]} range of time [s] @returns {string} a row for each picture and hand */
export function csvOf(hands, [from, to]) {
  const rows = [['time_s', 'hand', 'client', ...COLUMNS.map(([name]) => name)].join()];
  for (const {number, name, history} of hands) {
    for (let i = history.at(from); i < history.size && history.columns[0][i] <= to; ++i) {
      const values = COLUMNS.map(([, column]) => history.columns[column][i]);
      if (values.every(Number.isNaN)) continue;  // a gap
      rows.push([history.columns[0][i].toFixed(6), number, quoted(name), ...values.map((value) => (Number.isFinite(value) ? +value.toPrecision(DIGITS) : ''))].join());
    }
  }
  return `${rows.join('\n')}\n`;
}

/** @param {object[]} panes of makePane @param {string} title @param {object} colors of the theme @returns {HTMLCanvasElement} */
export function imageOf(panes, title, colors) {
  const drawn = panes.filter(({plot}) => plot);
  const ratio = devicePixelRatio;
  const width = Math.max(...drawn.map(({plot}) => plot.width));
  const height = drawn.reduce((sum, {plot}) => sum + plot.height + LEGEND, TITLE);
  const canvas = document.createElement('canvas');
  Object.assign(canvas, {width: Math.round(width * ratio), height: Math.round(height * ratio)});
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  context.fillStyle = colors.panel;
  context.fillRect(0, 0, width, height);
  context.textBaseline = 'middle';
  const write = (text, x, y, color, weight) => {
    context.fillStyle = color;
    context.font = `${weight} 12px ${FONT}`;
    context.fillText(text, x, y);
    return x + context.measureText(text).width;
  };
  write(title, 8, TITLE / 2, colors.ink, 600);
  let top = TITLE;
  for (const {plot, root, shown} of drawn) {
    write(root.querySelector('h3').textContent, 8, top + 10, colors.ink, 600);
    let x = 8;
    for (const {name, color} of shown) {
      context.fillStyle = colors[color];
      context.fillRect(x, top + 27, 12, 3);
      x = write(name, x + 17, top + 28, colors.muted, 400) + 14;
    }
    context.drawImage(plot.ctx.canvas, 0, top + LEGEND, plot.width, plot.height);
    top += plot.height + LEGEND;
  }
  return canvas;
}
