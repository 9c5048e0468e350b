// The figure of a step of the tour: depth and force against time, and the directions of both forces.

import {say} from './language.js';
import * as words from './words.js';

const SECONDS = 4;  // from left to right
const DEEPEST = 5;  // [mm] of the axis
const STRONGEST = 10;  // [N] of the axis
const [LEFT, TITLE, ROUND] = [40, 18, 78];  // [px] for the axes' words, for a title, for the directions
const FONT = '11px system-ui, sans-serif';

/** @param {HTMLCanvasElement} canvas @param {object} colors of the theme @param {import('./tour_motion.js').Trace} trace @param {import('./tour_motion.js').Trace | null} before of the step before */
export function drawFigure(canvas, colors, trace, before) {
  const [width, height, ratio] = [canvas.clientWidth, canvas.clientHeight, devicePixelRatio];
  if (width === 0) return;
  if (canvas.width !== Math.round(width * ratio)) Object.assign(canvas, {width: Math.round(width * ratio), height: Math.round(height * ratio)});
  const context = canvas.getContext('2d');
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = FONT;
  const half = height / 2;
  const deep = {left: LEFT, top: TITLE, width: width - LEFT - 4, height: half - TITLE - 4, most: DEEPEST};
  const strong = {...deep, top: half + TITLE, width: deep.width - ROUND, most: STRONGEST};
  const millimetres = (row) => 1000 * row.depth;
  axis(context, colors, deep, say('tour.depth'), words.number(DEEPEST, 0, 'mm'));
  axis(context, colors, strong, say('tour.force'), words.number(STRONGEST, 0, 'N'));
  if (before) line(context, before, millimetres, deep, colors.line, 1);
  line(context, trace, millimetres, deep, colors.ink, 1.5);
  line(context, trace, ({asked}) => asked, strong, colors.elastic, 1.2, [4, 3]);
  line(context, trace, ({held}) => held, strong, colors.rendered, 2);
  directions(context, colors, trace.rows.at(-1), {x: width - ROUND / 2 - 2, y: strong.top + strong.height - 6, size: strong.height - 16});
}

function axis(context, colors, {left, top, width, height}, name, most) {
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
  context.fillText(most, left - 4, top + 6);
  context.fillText('0', left - 4, top + height - 3);
  context.textAlign = 'left';
  context.fillText(name, left, top - 9);
}

/** What is above the axis is drawn at its end. */
function line(context, {rows, end}, value, {left, top, width, height, most}, color, wide, dash = []) {
  context.strokeStyle = color;
  context.lineWidth = wide;
  context.setLineDash(dash);
  context.beginPath();
  for (const row of rows) {
    const x = left + width * (1 - (end - row.time) / SECONDS);
    if (x < left) continue;
    context.lineTo(x, top + height * (1 - Math.min(Math.max(value(row) / most, 0), 1)));
  }
  context.stroke();
  context.setLineDash([]);
}

/** Two arrows of one length: where the scene asks for force, and where the device gives it. Up is the normal of the wall. */
function directions(context, colors, row, {x, y, size}) {
  if (!row || !(row.asked > 0.2)) return;
  const arrow = (normal, force, color, dash, wide) => {
    if (!(force > 0.05)) return;
    const up = normal / force;
    const aside = Math.sqrt(Math.max(1 - up * up, 0));
    context.strokeStyle = color;
    context.lineWidth = wide;
    context.setLineDash(dash);
    context.beginPath();
    context.moveTo(x, y);
    context.lineTo(x + aside * size, y - up * size);
    context.stroke();
    context.setLineDash([]);
  };
  arrow(row.heldNormal, row.held, colors.rendered, [], 4);
  arrow(row.askedNormal, row.asked, colors.elastic, [4, 3], 1.5);
}
