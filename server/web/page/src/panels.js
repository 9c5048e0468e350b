// The page around the scene: theme, sizes of the panels, and the keys.

import {forGood} from './kept.js';
import {say} from './language.js';

const NAMES = ['view', 'surface', 'line', 'grid', 'ink', 'muted', 'chosen', 'guide', 'elastic', 'friction', 'rendered', 'limit', 'panel', 'hand1', 'hand2', 'hand3', 'hand4', 'hand5', 'hand6', 'hand7', 'hand8'];
const root = document.documentElement;

/** Colors of the theme, as the style sheet gives them. */
function colors() {
  const style = getComputedStyle(root);
  return Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

/** Follows the system's theme until the user chooses one. @param {HTMLElement} button @param {(colors: object) => void} paint */
export function followTheme(button, paint) {
  const system = matchMedia('(prefers-color-scheme: dark)');
  const apply = () => {
    const dark = (forGood.get('feltwire-theme') ?? (system.matches ? 'dark' : 'light')) === 'dark';
    root.dataset.theme = dark ? 'dark' : 'light';
    button.textContent = say(dark ? 'head.light' : 'head.dark');
    paint(colors());
  };
  button.onclick = () => {
    forGood.set('feltwire-theme', root.dataset.theme === 'dark' ? 'light' : 'dark');
    apply();
  };
  system.addEventListener('change', apply);
  apply();
}

/**
 * A bar between two panels that can be dragged, or moved by the arrow keys.
 * @param {HTMLElement} bar @param {string} property of the style sheet: the size of the panel after the bar
 * @param {{axis: 'x' | 'y', least: number, most: () => number}} limits
 */
export function makeSplit(bar, property, {axis, least, most}) {
  const key = `feltwire${property}`;
  /** For screen readers. @param {number} size [px] */
  const tell = (size) => Object.assign(bar, {ariaValueMin: String(least), ariaValueMax: String(most()), ariaValueNow: String(size)});
  const set = (size) => {
    const fit = Math.round(Math.min(Math.max(size, least), most()));
    root.style.setProperty(property, `${fit}px`);
    tell(fit);
    forGood.set(key, String(fit));
  };
  const panel = () => bar.nextElementSibling.getBoundingClientRect()[axis === 'x' ? 'width' : 'height'];
  const stored = Number(forGood.get(key));
  if (stored > 0) set(stored);
  else tell(parseInt(getComputedStyle(root).getPropertyValue(property), 10));
  bar.onpointerdown = (event) => {
    bar.setPointerCapture(event.pointerId);
    const from = (axis === 'x' ? event.clientX : event.clientY) + panel();
    bar.onpointermove = (move) => set(from - (axis === 'x' ? move.clientX : move.clientY));
  };
  bar.onpointerup = bar.onpointercancel = () => (bar.onpointermove = null);
  bar.onkeydown = (event) => {
    const step = {ArrowLeft: 20, ArrowUp: 20, ArrowRight: -20, ArrowDown: -20}[event.key];
    if (!step) return;
    event.stopPropagation();
    event.preventDefault();
    set(panel() + step);
  };
}

/** Panels beside the scene. One is open at most. */
export class Asides {
  #all = [];

  /** @param {HTMLElement} panel @param {HTMLButtonElement} button that opens and closes it @param {(open: boolean) => void} shown called after each change */
  add(panel, button, shown) {
    this.#all.push({panel, button, shown});
    button.onclick = () => this.show(panel.hidden ? panel : null);
  }

  /** @param {HTMLElement | null} wanted null: none */
  show(wanted) {
    for (const {panel, button, shown} of this.#all) {
      const open = panel === wanted;
      if (open !== panel.hidden) continue;
      if (!open && panel.contains(document.activeElement)) button.focus();
      panel.hidden = !open;
      button.setAttribute('aria-expanded', String(open));
      shown(open);
    }
    document.body.classList.toggle('administers', wanted !== null);
  }
}

/**
 * Binds keys and lists them in the help.
 * @param {HTMLElement} list @param {{keys: string[], shown?: string, text: string, act: (key: string, event: KeyboardEvent) => void}[]} bindings
 * @param {() => boolean} active whether they hold now
 */
export function bindKeys(list, bindings, active = () => true) {
  const acts = new Map();
  for (const {keys, shown, text, act} of bindings) {
    const [term, meaning] = ['dt', 'dd'].map((tag) => document.createElement(tag));
    term.textContent = shown ?? keys.join(' ');
    meaning.textContent = text;
    list.append(term, meaning);
    for (const key of keys) {
      if (acts.has(key)) throw new Error(`the key ${key} is bound twice`);
      acts.set(key, act);
    }
  }
  addEventListener('keydown', (event) => {
    if (!active() || event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.('input, select, dialog[open]')) return;
    if (event.target.closest?.('button') && [' ', 'Enter'].includes(event.key)) return;
    const act = acts.get(event.key);
    if (!act) return;
    event.preventDefault();
    act(event.key, event);
  });
}
