// The time bar: for each recording the largest forces and the reasons over its whole time, and the moment that is shown.

import {CLASSES} from './reasons.js';

const ROW = 40;  // [pixels] of one recording
const STRIP = 7;  // [pixels] of it for the reasons
const FLAG = 5;  // [pixels] of a mark
const EDGE = 6;  // [pixels] left and right of the times

export class TimeBar {
  /** @param {HTMLElement} root a slider with a canvas @param {(time: number) => void} seek */
  constructor(root, seek) {
    this.root = root;
    this.canvas = root.querySelector('canvas');
    this.colors = null;
    this.from = 0;
    this.to = 1;
    const go = (event) => {
      const {left, width} = this.root.getBoundingClientRect();
      const share = (event.clientX - left - EDGE) / Math.max(width - 2 * EDGE, 1);
      seek(this.from + Math.min(Math.max(share, 0), 1) * (this.to - this.from));
    };
    root.onpointerdown = (event) => {
      root.setPointerCapture(event.pointerId);
      root.onpointermove = go;
      go(event);
    };
    root.onpointerup = root.onpointercancel = () => (root.onpointermove = null);
  }

  /**
   * @param {{overview: import('./overview.js').Overview, offset: number}[]} rows one a recording
   * @param {number} time [s] @param {string} said the time in words
   */
  show(rows, time, said) {
    this.root.style.height = `${ROW * Math.max(rows.length, 1)}px`;
    this.root.setAttribute('aria-valuemin', this.from.toFixed(3));
    this.root.setAttribute('aria-valuemax', this.to.toFixed(3));
    this.root.setAttribute('aria-valuenow', time.toFixed(3));
    this.root.setAttribute('aria-valuetext', said);
    const {clientWidth: width, clientHeight: height} = this.root;
    if (!this.colors || width === 0) return;
    const scale = devicePixelRatio;
    [this.canvas.width, this.canvas.height] = [Math.round(width * scale), Math.round(height * scale)];
    const context = this.canvas.getContext('2d');
    context.scale(scale, scale);
    const x = (at) => EDGE + ((at - this.from) / (this.to - this.from)) * (width - 2 * EDGE);
    const most = Math.max(...rows.map(({overview}) => overview.most), 1e-9);  // One scale, so that recordings compare.
    rows.forEach((row, i) => this.#drawRow(context, row, ROW * i, x, most));
    context.fillStyle = this.colors.ink;
    context.fillRect(Math.round(x(time)) - 1, 0, 2, height);
  }

  /** A flag at each moment that is marked. */
  #drawMarks(context, marks, offset, top, x) {
    context.fillStyle = this.colors.guide;
    for (const {time} of marks) {
      const left = Math.round(x(offset + time));
      context.fillRect(left, top, 1, ROW);
      context.fillRect(left, top, FLAG, FLAG);
    }
  }

  #drawRow(context, {overview, offset}, top, x, most) {
    const {colors} = this;
    const [parts, {duration}] = [overview.parts, overview.recording];
    const base = top + ROW - STRIP - 3;
    const tall = base - top - 3;
    context.fillStyle = colors.grid;
    context.fillRect(x(offset), base, x(offset + duration) - x(offset), 1);
    this.#drawMarks(context, overview.marks, offset, top, x);
    for (let part = 0; part < parts; ++part) {
      const left = x(offset + (duration * part) / parts);
      const width = Math.max(x(offset + (duration * (part + 1)) / parts) - left + 0.5, 1);
      const bar = (force, color) => {
        if (!(force > 0)) return;
        context.fillStyle = color;
        context.fillRect(left, base - (tall * force) / most, width, (tall * force) / most);
      };
      bar(overview.asked[part], colors.line);
      bar(overview.held[part], colors.rendered);
      const share = worst(overview.classes, part);
      if (share < 0) continue;
      context.fillStyle = share === 3 ? colors.grid : colors[CLASSES[share].color];
      context.fillRect(left, base + 2, width, STRIP);
    }
  }
}

/** What a part of the time is shown as: force that was kept away or cut is seen even where it was short. */
function worst(classes, part) {
  const at = part * CLASSES.length;
  for (const kind of [2, 1, 0, 3]) if (classes[at + kind] > 0) return kind;
  return -1;
}
