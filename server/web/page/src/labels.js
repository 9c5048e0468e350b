// Names of the hands beside them, as text above the 3D view.

import {AT, length3} from './messages.js';
import * as words from './words.js';

const CROWD = 6;  // hands from which only the chosen one's force is written
const spot = {x: 0, y: 0, seen: false};

/** Puts a label beside `spot`. It is written only where it changes: each writing costs the browser a layout. */
function put(label, right, down) {
  const [x, y] = [Math.round(spot.x + right), Math.round(spot.y + down)];
  if (label.seen !== spot.seen) label.element.hidden = !spot.seen;
  if (spot.seen && (label.x !== x || label.y !== y)) {
    label.element.style.transform = `translate(${x}px, ${y}px)`;
    [label.x, label.y] = [x, y];
  }
  label.seen = spot.seen;
}

export class Labels {
  /** @param {HTMLElement} parent lets the pointer through, so that a drag that begins on a label turns the camera */
  constructor(parent) {
    this.parent = parent;
    this.labels = new Map();
    this.axes = new Map();
  }

  /** Moves the labels to their hands. @param {import('./view.js').View} view */
  move(view) {
    const {picture} = view;
    for (const {name, point} of view.axisEnds) {
      const label = this.axes.get(name) ?? this.#makeAxis(name);
      view.projectPoint(point, spot);
      put(label, 3, -16);
    }
    for (let i = 0; i < (picture?.hands ?? 0); ++i) {
      const label = this.labels.get(picture.words[picture.handAt(i) + AT.number]);
      if (!label) continue;
      view.project(i, spot);
      put(label, 14, 8);
    }
  }

  /**
   * Writes names and forces; a few times a second is enough.
   * @param {Map<number, import('./hands.js').Hand>} hands @param {(number: number) => string} name @param {number | null} chosen
   */
  write(hands, name, chosen) {
    for (const [number, label] of this.labels) {
      if (hands.has(number)) continue;
      label.element.remove();
      this.labels.delete(number);
    }
    for (const [number, hand] of hands) {
      const label = this.labels.get(number) ?? this.#make(number);
      label.element.classList.toggle('chosen', number === chosen);
      const title = name(number);
      if (label.name.textContent !== title) label.name.textContent = title;
      const rendered = length3(hand.floats, AT.rendered);
      const room = hands.size <= CROWD || number === chosen;
      const text = rendered > 0.005 && room ? words.force(rendered) : '';
      if (label.value.textContent !== text) label.value.textContent = text;
    }
  }

  /** @returns {number | null} number of the hand whose label is at a place of the window */
  at(x, y) {
    for (const [number, {element}] of this.labels) {
      const {left, right, top, bottom} = element.getBoundingClientRect();
      if (x >= left && x < right && y >= top && y < bottom) return number;
    }
    return null;
  }

  #makeAxis(name) {
    const element = document.createElement('div');
    element.textContent = name;
    element.className = 'axis';
    this.parent.append(element);
    const label = {element};
    this.axes.set(name, label);
    return label;
  }

  #make(number) {
    const [element, name, value] = ['div', 'span', 'b'].map((tag) => document.createElement(tag));
    element.append(name, ' ', value);
    this.parent.append(element);
    const label = {element, name, value};
    this.labels.set(number, label);
    return label;
  }
}
