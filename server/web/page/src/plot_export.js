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
const ROW = 18;  // [px] height of a line of words
const LEFT = 8;  // [px]
const MARK = 12;  // [px] width of a line's color
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
  const canvas = document.createElement('canvas');
  const context = canvas.getContext('2d');
  const style = (weight) => (context.font = `${weight} 12px ${FONT}`);
  style(400);
  const legends = drawn.map(({shown}) => placed(shown, width, (name) => context.measureText(name).width));
  const height = drawn.reduce((sum, {plot}, i) => sum + plot.height + legends[i].height, TITLE);
  Object.assign(canvas, {width: Math.round(width * ratio), height: Math.round(height * ratio)});
  context.scale(ratio, ratio);
  context.fillStyle = colors.panel;
  context.fillRect(0, 0, width, height);
  context.textBaseline = 'middle';
  const write = (text, x, y, color, weight) => {
    context.fillStyle = color;
    style(weight);
    context.fillText(text, x, y);
  };
  write(title, LEFT, TITLE / 2, colors.ink, 600);
  let top = TITLE;
  drawn.forEach(({plot, root}, i) => {
    write(root.querySelector('h3').textContent, LEFT, top + ROW / 2, colors.ink, 600);
    for (const {name, color, x, y} of legends[i].items) {
      context.fillStyle = colors[color];
      context.fillRect(x, top + y - 1, MARK, 3);
      write(name, x + MARK + 5, top + y, colors.muted, 400);
    }
    top += legends[i].height;
    context.drawImage(plot.ctx.canvas, 0, top, plot.width, plot.height);
    top += plot.height;
  });
  return canvas;
}

/** Names in rows below a heading, as many as fit in each. @param {{name: string, color: string}[]} lines @param {(name: string) => number} wide [px] */
function placed(lines, width, wide) {
  let [x, y] = [LEFT, 1.5 * ROW];
  const items = lines.map(({name, color}) => {
    const size = MARK + 5 + wide(name);
    if (x > LEFT && x + size > width) [x, y] = [LEFT, y + ROW];
    const item = {name, color, x, y};
    x += size + 14;
    return item;
  });
  return {items, height: y + ROW / 2 + 2};
}
