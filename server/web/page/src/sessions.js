// The table of all sessions; a row chooses its hand. On a phone each row is a card.

import {COLUMNS, columnsThatFit, compare} from './columns.js';
import {make} from './elements.js';
import {forGood} from './kept.js';
import {say} from './language.js';
import {fitting} from './words.js';

const KEY = 'feltwire-columns';
const EDGES = 17;  // [px] beside the text of a cell
const LETTER = 7.6;  // [px]
const SORT_PERIOD = 2000;  // [ms] in which values may change their order before rows do
const CARD = 80;  // [letters] of columns that a card has unless the user chooses

/** @returns {Map<string, boolean>} columns that the user chose, as the browser kept them */
function keptColumns() {
  try {
    return new Map(Object.entries(JSON.parse(forGood.get(KEY) ?? '{}')));
  } catch {
    return new Map();
  }
}

export class Sessions {
  /** @param {HTMLTableElement} table @param {HTMLElement} menu for the choice of columns and order @param {(number: number) => void} choose */
  constructor(table, menu, choose) {
    this.choose = choose;
    this.table = table;
    this.rows = new Map();
    this.pen = document.createElement('canvas').getContext('2d');  // for the widths of texts
    this.fonts = {plain: '', bold: ''};
    this.widths = COLUMNS.map(() => 0);  // [px]
    this.sessions = new Map();
    this.reasons = [];  // of the server's hello
    this.chosenColumns = keptColumns();
    this.shown = COLUMNS.map(() => true);
    this.order = {column: 0, down: false};
    this.sortedAt = 0;
    this.#makeHead();
    this.body = table.createTBody();
    this.#makeMenu(menu);
    this.cards = matchMedia('(max-width: 760px)');
    this.cards.addEventListener('change', () => this.#fit());
    new ResizeObserver(() => this.#fit()).observe(table.parentElement);
    this.#fit();
  }

  /** @param {object[]} sessions of the server's message */
  set(sessions) {
    this.sessions = new Map(sessions.map((session) => [session.number, session]));
  }

  /** @param {number} number @returns {string} what a hand is called */
  name(number) {
    return this.sessions.get(number)?.client ?? say('hand.number', {number});
  }

  /** @param {Map<number, import('./hands.js').Hand>} hands @param {number | null} chosen */
  show(hands, chosen) {
    const numbers = [...new Set([...this.sessions.keys(), ...hands.keys()])];
    for (const [number, row] of this.rows) {
      if (numbers.includes(number)) continue;
      row.remove();
      this.rows.delete(number);
    }
    const before = this.rows.size;
    for (const number of numbers) {
      const row = this.rows.get(number) ?? this.#makeRow(number);
      row.setAttribute('aria-selected', String(number === chosen));
      const session = this.sessions.get(number) ?? {number};
      COLUMNS.forEach(({write, text}, i) => {
        const written = write(session, hands.get(number), this.reasons);
        const cell = row.cells[i];
        const bold = number === chosen;
        if (cell.written === written && (!text || cell.bold === bold)) return;
        [cell.written, cell.bold] = [written, bold];
        if (text) this.#cut(cell, i);
        else cell.textContent = written;
      });
    }
    const idle = !this.body.matches(':hover') && !this.body.contains(document.activeElement);
    if (this.rows.size > before || (idle && performance.now() - this.sortedAt > SORT_PERIOD)) this.#sort(hands);
    this.hands = hands;
  }

  /** Writes a text as far as the column has room. */
  #cut(cell, column) {
    const room = this.cards.matches ? Infinity : this.widths[column] - EDGES;
    this.pen.font = cell.bold ? this.fonts.bold : this.fonts.plain;
    cell.textContent = fitting(cell.written, room, (text) => this.pen.measureText(text).width);
    cell.title = cell.written;
  }

  #sort(hands) {
    this.sortedAt = performance.now();
    const {column, down} = this.order;
    const {value, write} = COLUMNS[column];
    const values = new Map([...this.rows.keys()].map((number) => {
      const session = this.sessions.get(number) ?? {number};
      return [number, value ? value(session, hands.get(number)) : write(session, hands.get(number), this.reasons)];
    }));
    const sorted = [...this.rows.keys()].sort((a, b) => (down ? -1 : 1) * compare(values.get(a), values.get(b)) || a - b).map((number) => this.rows.get(number));
    if (sorted.some((row, i) => row !== this.body.rows[i])) this.body.append(...sorted);
  }

  /** @param {number} column by which rows are sorted; once more: the other way round */
  #sortBy(column, down = this.order.column === column && !this.order.down) {
    this.order = {column, down};
    this.headings.forEach((heading, i) => (heading.ariaSort = i !== column ? 'none' : down ? 'descending' : 'ascending'));
    this.sorting.value = String(column);
    this.#sort(this.hands ?? new Map());
  }

  #makeHead() {
    const head = this.table.createTHead().insertRow();
    this.headings = COLUMNS.map(({name, hint, text}, i) => {
      const button = make('button', {title: say('table.sort.hint', {what: hint || name}), onclick: () => this.#sortBy(i)}, name);
      const cell = make('th', {scope: 'col', className: text ? 'text' : ''}, button);
      cell.ariaSort = i === 0 ? 'ascending' : 'none';
      head.append(cell);
      return cell;
    });
  }

  #makeMenu(menu) {
    this.boxes = COLUMNS.map(({id}) => make('input', {type: 'checkbox', onchange: (event) => this.#chooseColumn(id, event.target.checked)}));
    this.sorting = make('select', {onchange: (event) => this.#sortBy(Number(event.target.value), false)}, ...COLUMNS.map(({name}, i) => new Option(name, String(i))));
    const byWidth = make('button', {title: say('table.width.hint'), onclick: () => this.#chooseColumn(null)}, say('table.width'));
    menu.append(make('summary', {}, say('table.columns')), make('div', {}, make('label', {}, say('table.sort'), this.sorting), byWidth,
      ...COLUMNS.map(({name}, i) => make('label', {}, this.boxes[i], ` ${name}`))));
  }

  /** @param {string | null} id null: none is chosen any more */
  #chooseColumn(id, shown) {
    if (id === null) this.chosenColumns.clear();
    else this.chosenColumns.set(id, shown);
    forGood.set(KEY, JSON.stringify(Object.fromEntries(this.chosenColumns)));
    this.#fit();
  }

  /** Shows the columns that the user chose, and others while there is room. */
  #fit() {
    this.shown = columnsThatFit(this.cards.matches ? CARD : this.table.parentElement.clientWidth / LETTER, this.chosenColumns);
    const wide = COLUMNS.reduce((sum, column, i) => sum + (this.shown[i] ? column.wide : 0), 0);
    this.table.style.minWidth = this.cards.matches ? '' : `${Math.floor(wide * LETTER)}px`;
    this.headings.forEach((cell, i) => {
      cell.style.width = `${(100 * COLUMNS[i].wide) / wide}%`;
      cell.hidden = !this.shown[i];
      this.boxes[i].checked = this.shown[i];
    });
    for (const row of this.rows.values()) this.#hideCells(row);
    const {fontSize, fontFamily} = getComputedStyle(this.table);
    this.fonts = {plain: `${fontSize} ${fontFamily}`, bold: `600 ${fontSize} ${fontFamily}`};
    const width = Math.max(this.table.parentElement.clientWidth, Math.floor(wide * LETTER));
    this.widths = COLUMNS.map((column) => (width * column.wide) / wide);
    for (const row of this.rows.values()) [...row.cells].forEach((cell, i) => COLUMNS[i].text && cell.written !== undefined && this.#cut(cell, i));
  }

  #hideCells(row) {
    [...row.cells].forEach((cell, i) => (cell.hidden = !this.shown[i]));
  }

  #makeRow(number) {
    const row = this.body.insertRow();
    row.tabIndex = 0;
    for (const {id, name, text} of COLUMNS) {
      const cell = row.insertCell();
      cell.className = text ? 'text' : '';
      cell.dataset.name = name;
      cell.dataset.column = id;
    }
    this.#hideCells(row);
    row.onclick = () => this.choose(number);
    row.onkeydown = (event) => {
      if (event.key === 'Enter') this.choose(number);
    };
    this.rows.set(number, row);
    return row;
  }
}
