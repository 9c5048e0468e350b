// The table of all sessions; a row chooses its hand.

import * as words from './words.js';

/** Heading, unit or explanation, and how a session's value is written. */
const COLUMNS = [
  ['Hand', 'number of the session', (s) => `${s.number}`],
  ['Client', 'name that the token gives', (s) => s.client ?? '–'],
  ['Device', '', (s) => s.device ?? '–'],
  ['Force', 'rendered by the device now', (s, hand) => (hand ? words.force(hand.rendered) : '–')],
  ['Bounded by', 'why less force is rendered than the scene asks for; the strip says it in words', (s, hand, reasons) => (
    [...new Set(hand?.activeReasons().map((bit) => reasons[bit]).filter((reason) => reason && reason.cuts !== false)
      .map((reason) => reason.name).sort())].join(', ') || '–')],
  ['Round trip', 'of a sample and its reply', (s) => words.number(s.round_trip_ms, 1, 'ms')],
  ['Late', 'servo ticks that came a whole period late or more', (s) => (s.late_ticks ?? '–').toLocaleString('en')],
  ['Loss', 'of datagrams', (s) => words.percent(s.loss ?? null)],
  ['Delivered', 'energy to the hand; negative: the hand gave', (s) => words.energy(s.delivered_j)],
  ['Servo', 'rate of the device', (s) => words.number(s.rate_hz, 0, 'Hz')],
  ['Packets', 'rate of datagrams', (s) => words.number(s.packet_hz, 0, 'Hz')],
  ['Mode', 'how forces are bounded', (s) => [s.mode, s.side && `at the ${s.side}`].filter(Boolean).join(', ') || '–'],
  ['Samples', 'since the session began', (s) => (s.samples ?? '–').toLocaleString('en')],
  ['Time', 'since the session began', (s) => words.duration(s.seconds)],
];

export class Sessions {
  /** @param {HTMLTableElement} table @param {(number: number) => void} choose */
  constructor(table, choose) {
    this.choose = choose;
    this.rows = new Map();
    this.sessions = new Map();
    this.reasons = [];  // of the server's hello
    const head = table.createTHead().insertRow();
    for (const [name, hint] of COLUMNS) {
      const cell = document.createElement('th');
      cell.scope = 'col';
      cell.textContent = name;
      cell.title = hint;
      head.append(cell);
    }
    this.body = table.createTBody();
  }

  /** @param {object[]} sessions of the server's message */
  set(sessions) {
    this.sessions = new Map(sessions.map((session) => [session.number, session]));
  }

  /** @param {number} number @returns {string} what a hand is called */
  name(number) {
    return this.sessions.get(number)?.client ?? `hand ${number}`;
  }

  /** @param {Map<number, import('./hands.js').Hand>} hands @param {number | null} chosen */
  show(hands, chosen) {
    const numbers = [...new Set([...this.sessions.keys(), ...hands.keys()])].sort((a, b) => a - b);
    for (const [number, row] of this.rows) {
      if (numbers.includes(number)) continue;
      row.remove();
      this.rows.delete(number);
    }
    numbers.forEach((number, place) => {
      const row = this.rows.get(number) ?? this.#makeRow(number, place);
      row.setAttribute('aria-selected', String(number === chosen));
      const session = this.sessions.get(number) ?? {number};
      COLUMNS.forEach(([, , write], i) => {
        const text = write(session, hands.get(number), this.reasons);
        if (row.cells[i].textContent !== text) row.cells[i].textContent = text;
      });
    });
  }

  #makeRow(number, place) {
    const row = this.body.insertRow(Math.min(place, this.body.rows.length));
    row.tabIndex = 0;
    for (let i = 0; i < COLUMNS.length; ++i) row.insertCell();
    row.onclick = () => this.choose(number);
    row.onkeydown = (event) => {
      if (event.key === 'Enter') this.choose(number);
    };
    this.rows.set(number, row);
    return row;
  }
}
