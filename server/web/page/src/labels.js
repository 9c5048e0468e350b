// Names of the hands beside them, as text above the 3D view. They are placed apart; those that find no place are counted.

import {say} from './language.js';
import {AT, length3} from './messages.js';
import * as words from './words.js';

const CROWD = 6;  // hands from which only the chosen one's force is written
const NAME_MOST = 18;  // letters of a name that are shown
const MOST = 12;  // names that are shown
const spot = {x: 0, y: 0, seen: false};

/** Where a label may be, in turns: to the right or left of its hand, and how far below. [px] */
const SLOTS = [8, -28, 30, -50, 52, -72].flatMap((down) => [{side: 1, down}, {side: -1, down}]);
const ASIDE = 14;  // [px] between a hand and its label
const GAP = 2;  // [px] between two labels

/** Moves a label. It is written only where it changes: each writing costs the browser a layout. @param {boolean} seen */
function put(label, seen, left, top) {
  const [x, y] = [Math.round(left), Math.round(top)];
  if (label.seen !== seen) label.element.style.visibility = seen ? '' : 'hidden';
  if (seen && (label.x !== x || label.y !== y)) {
    label.element.style.transform = `translate(${x}px, ${y}px)`;
    [label.x, label.y] = [x, y];
  }
  label.seen = seen;
}

export class Labels {
  /** @param {HTMLElement} parent lets the pointer through, so that a drag that begins on a label turns the camera */
  constructor(parent) {
    this.parent = parent;
    this.labels = new Map();
    this.axes = new Map();
    this.chosen = null;
    this.count = document.createElement('p');
    this.count.hidden = true;
    parent.append(this.count);
  }

  /** Moves the labels to their hands. @param {import('./view.js').View} view */
  move(view) {
    const {picture} = view;
    for (const {name, point} of view.axisEnds) {
      const label = this.axes.get(name) ?? this.#makeAxis(name);
      view.projectPoint(point, spot);
      put(label, spot.seen, spot.x + 3, spot.y - 16);
    }
    const wanted = [];
    for (let i = 0; i < (picture?.hands ?? 0); ++i) {
      const label = this.labels.get(picture.words[picture.handAt(i) + AT.number]);
      if (!label) continue;
      view.project(i, spot);
      if (spot.seen) wanted.push({label, x: spot.x, y: spot.y});
      else put(label, false, 0, 0);
    }
    const first = wanted.findIndex(({label}) => label === this.labels.get(this.chosen));
    if (first > 0) wanted.unshift(...wanted.splice(first, 1));  // It has the first choice.
    const taken = [];
    let hidden = 0;
    for (const {label, x, y} of wanted) {
      const place = taken.length < MOST ? this.#freePlace(label, x, y, taken) : null;
      if (place) taken.push(place);
      else hidden += 1;
      put(label, place !== null, place?.left ?? 0, place?.top ?? 0);
    }
    this.count.hidden = hidden === 0;
    const text = hidden === 1 ? say('scene.more.one') : say('scene.more', {count: hidden});
    if (hidden > 0 && this.count.textContent !== text) this.count.textContent = text;
  }

  /**
   * Writes names and forces; a few times a second is enough.
   * @param {Map<number, import('./hands.js').Hand>} hands @param {(number: number) => string} name @param {number | null} chosen
   */
  write(hands, name, chosen) {
    this.chosen = chosen;
    for (const [number, label] of this.labels) {
      if (hands.has(number)) continue;
      label.element.remove();
      this.labels.delete(number);
    }
    const changed = [];
    for (const [number, hand] of hands) {
      const label = this.labels.get(number) ?? this.#make(number);
      label.full = name(number);
      const rendered = length3(hand.floats, AT.rendered);
      const room = hands.size <= CROWD || number === chosen;
      const text = rendered > 0.005 && room ? words.force(rendered) : '';
      const title = words.middle(label.full, NAME_MOST);
      if (label.name.textContent === title && label.value.textContent === text && label.chosen === (number === chosen)) continue;
      label.name.textContent = title;
      label.value.textContent = text;
      label.chosen = number === chosen;
      label.element.classList.toggle('chosen', label.chosen);
      changed.push(label);
    }
    for (const label of changed) [label.width, label.height] = [label.element.offsetWidth, label.element.offsetHeight];  // One layout for all.
  }

  /** @returns {number | null} number of the hand whose label is at a place of the window */
  at(x, y) {
    for (const [number, {element, seen}] of this.labels) {
      const {left, right, top, bottom} = element.getBoundingClientRect();
      if (seen && x >= left && x < right && y >= top && y < bottom) return number;
    }
    return null;
  }

  /** @returns {string} the whole name of the hand whose label is at a place of the window; empty: there is none, or it is whole */
  cutName(x, y) {
    const label = this.labels.get(this.at(x, y));
    return label && label.name.textContent !== label.full ? label.full : '';
  }

  /** A place for a label that no other has; the one that it had is the first to be tried, so that labels are calm. */
  #freePlace(label, x, y, taken) {
    const {width, height} = label;
    for (let turn = -1; turn < SLOTS.length; ++turn) {
      const slot = turn < 0 ? label.slot : turn;
      const {side, down} = SLOTS[slot];
      const left = side > 0 ? x + ASIDE : x - ASIDE - width;
      const top = y + down;
      const free = taken.every((other) => left >= other.left + other.width + GAP || other.left >= left + width + GAP ||
        top >= other.top + other.height + GAP || other.top >= top + height + GAP);
      if (!free) continue;
      label.slot = slot;
      return {left, top, width, height};
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
    const label = {element, name, value, full: '', chosen: false, slot: 0, width: 0, height: 0, seen: true};
    this.labels.set(number, label);
    return label;
  }
}
