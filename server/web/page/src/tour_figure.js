// The figures of the tour. Each step has its own: what the law of the step limits, or what the delay does, drawn as the hand moves.

import {say} from './language.js';
import {roundDown, number} from './words.js';

const [LEFT, TITLE, ROUND] = [58, 18, 78];  // [px] for the axes' words, for a title, for the directions
const FONT = '11px system-ui, sans-serif';
const LOOP = 2;  // [s] of a hand's force over its depth

/** Values of a row of a trace. A force along the wall has no sign. */
const millimetres = ({depth}) => 1000 * depth;
const micrometres = ({shaking}) => 1e6 * shaking;
const millijoules = ({delivered}) => -1000 * delivered;
const aside = (size, normal) => Math.sqrt(Math.max(size * size - normal * normal, 0));
const askedAside = ({asked, askedNormal}) => aside(asked, askedNormal);
const heldAside = ({held, heldNormal}) => aside(held, heldNormal);

/**
 * A line: whose trace, by the name of a law or of a step (`now`: this step's, `before`: that of the step before), its value, and its look.
 * @typedef {{of: string, value: (row: object) => number, color: string, wide: number, dash?: number[]}} Line
 * A panel of a figure: its title, its unit, the least end of its axis, the seconds from left to right, and its lines. `below`: it also
 * shows values below zero. `ends`: the axis is no longer, and what is above it is drawn at its end: a scene may ask for a hundred times the device's force. `over`: what is to the right instead of the time.
 * @typedef {{title: string, unit: string, least: number, seconds?: number, below?: boolean, ends?: boolean, lines: Line[], over?: (row: object) => number, directions?: boolean}} Panel
 */
const asked = (value, of = 'now') => ({of, value, color: 'elastic', wide: 1.2, dash: [4, 3]});
const held = (value) => ({of: 'now', value, color: 'rendered', wide: 2});
const grey = (of, value) => ({of, value, color: 'line', wide: 1});
const depths = {title: say('tour.depth'), unit: 'mm', least: 5, ends: true, lines: [grey('before', millimetres), {of: 'now', value: millimetres, color: 'ink', wide: 1.5}]};
const forces = {title: say('tour.force'), unit: 'N', least: 10, ends: true, directions: true, lines: [asked((row) => row.asked), held((row) => row.held)]};
const shaking = (lines) => ({title: say('tour.shaking'), unit: 'µm', least: 100, seconds: 1, below: true, lines});
const loop = {title: say('tour.loop'), unit: 'N', least: 10, ends: true, over: millimetres, lines: [grey('before', (row) => row.held), {of: 'now', value: (row) => row.held, color: 'rendered', wide: 2}]};

/** The panels of each figure, one above the other, by the name of the step or of the law. @type {Record<string, Panel[]>} */
export const FIGURES = {
  none: [
    shaking([{of: 'now', value: micrometres, color: 'limit', wide: 1.5}, {of: 'usual', value: micrometres, color: 'rendered', wide: 2}]),
    {...forces, directions: false},
  ],
  total_energy: [
    {title: say('tour.energy'), unit: 'mJ', least: 10, below: true, lines: [{of: 'now', value: millijoules, color: 'elastic', wide: 2}]},
    shaking([{of: 'now', value: micrometres, color: 'limit', wide: 1.5}]),
  ],
  per_axis: [
    {title: say('tour.across'), unit: 'N', least: 10, ends: true, lines: [asked((row) => row.askedNormal), held((row) => row.heldNormal)]},
    {title: say('tour.along'), unit: 'N', least: 10, ends: true, lines: [asked(askedAside), held(heldAside)]},
  ],
  per_axis_projected: [
    {title: say('tour.angle'), unit: '°', least: 45, directions: true, lines: [{of: 'per_axis', value: ({off}) => off, color: 'line', wide: 1}, {of: 'now', value: ({off}) => off, color: 'rendered', wide: 2}]},
    depths,
  ],
  ours: [depths, forces],
  delay: [loop],
  model: [loop],
};

/**
 * @param {HTMLCanvasElement} canvas @param {object} colors of the theme @param {string} name of FIGURES
 * @param {(of: string) => import('./tour_motion.js').Trace | null} traceOf a line
 */
export function drawFigure(canvas, colors, name, traceOf) {
  const [width, height, ratio] = [canvas.clientWidth, canvas.clientHeight, devicePixelRatio];
  if (width === 0) return;
  if (canvas.width !== Math.round(width * ratio)) Object.assign(canvas, {width: Math.round(width * ratio), height: Math.round(height * ratio)});
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = FONT;
  const panels = FIGURES[name];
  panels.forEach((panel, i) => {
    const share = height / panels.length;
    const box = {left: LEFT, top: i * share + TITLE, width: width - LEFT - 4 - (panel.directions ? ROUND : 0), height: share - TITLE - (panel.over ? TITLE : 4)};
    drawPanel(context, colors, panel, box, traceOf);
    if (panel.directions) drawDirections(context, colors, traceOf('now')?.rows.at(-1), {x: width - ROUND / 2 - 2, y: box.top + box.height - 6, size: box.height - 16});
  });
}

function drawPanel(context, colors, panel, box, traceOf) {
  const lines = panel.lines.map((line) => ({...line, points: pointsOf(panel, line, traceOf(line.of))}));
  const points = lines.flatMap((line) => line.points).filter((point) => point.every(Number.isFinite));
  const most = panel.ends ? panel.least : roundUp(points.reduce((sum, [, value]) => Math.max(sum, panel.below ? Math.abs(value) : value), panel.least));
  const far = panel.over ? roundUp(points.reduce((sum, [at]) => Math.max(sum, at), 1)) : 1;
  const x = (value) => box.left + (box.width * value) / far;
  const y = (value) => box.top + box.height * (panel.below ? 0.5 * (1 - value / most) : 1 - Math.min(Math.max(value, 0) / most, 1));
  drawAxis(context, colors, box, panel.below ? -most : 0, most, panel);
  if (panel.over) {
    context.textAlign = 'right';
    context.fillText(`${number(far, 0, 'mm')} ${say('tour.depth')}`, box.left + box.width, box.top + box.height + 10);
  }
  for (const {points: own, color, wide, dash} of lines) {
    context.strokeStyle = colors[color];
    context.lineWidth = wide;
    context.setLineDash(dash ?? []);
    context.beginPath();
    for (const [at, value] of own) if (Number.isFinite(value)) context.lineTo(x(at), y(value));
    context.stroke();
  }
  context.setLineDash([]);
}

/** @returns {number[][]} place to the right, 0 to 1 or the value that is there, and the value */
function pointsOf({over, seconds = 4}, {value}, trace) {
  if (!trace) return [];
  const span = over ? LOOP : seconds;
  return trace.rows.filter(({time}) => time >= trace.end - span).map((row) => [over ? over(row) : 1 - (trace.end - row.time) / span, value(row)]);
}

/** The smallest of 1, 2 and 5 times a power of ten that is not below a value. */
function roundUp(value) {
  const below = roundDown(value);
  return below >= value * (1 - 1e-9) ? below : roundDown(below * 2.5);
}

function drawAxis(context, colors, {left, top, width, height}, low, most, {title, unit}) {
  context.strokeStyle = colors.grid;
  context.lineWidth = 1;
  for (const share of [0, 0.5, 1]) {
    const y = Math.round(top + share * height) + 0.5;
    context.beginPath();
    context.moveTo(left, y);
    context.lineTo(left + width, y);
    context.stroke();
  }
  context.fillStyle = colors.muted;
  context.textBaseline = 'middle';
  context.textAlign = 'right';
  context.fillText(number(most, 0, unit), left - 4, top + 6);
  context.fillText(number(low, 0), left - 4, top + height - 3);
  context.textAlign = 'left';
  context.fillText(title, left, top - 9);
}

/** Two arrows of one length: where the scene asks for force, and where the device gives it. Up is the normal of the wall. */
function drawDirections(context, colors, row, {x, y, size}) {
  if (!row || !(row.asked > 0.2)) return;
  const arrow = (normal, force, color, dash, wide) => {
    if (!(force > 0.05)) return;
    const up = normal / force;
    context.strokeStyle = color;
    context.lineWidth = wide;
    context.setLineDash(dash);
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + aside(1, up) * size, y - up * size);
    context.stroke();
    context.setLineDash([]);
  };
  arrow(row.heldNormal, row.held, colors.rendered, [], 4);
  arrow(row.askedNormal, row.asked, colors.elastic, [4, 3], 1.5);
}
