// Columns of the table of hands: what each says, how wide it is, and what it is sorted by.

import * as words from './words.js';

const NAME_MOST = 22;  // letters of a name that are shown
const count = (value) => (value ?? '–').toLocaleString('en');

/** Names of the reasons that take force off a hand now. */
const bounds = (hand, reasons) => [...new Set(hand?.activeReasons().map((bit) => reasons[bit]).filter((reason) => reason && reason.cuts !== false)
  .map((reason) => reason.name).sort())].join(', ');

/**
 * `wide`: [letters] at least. `rank`: the lower, the longer it stays in a narrow table. `write`: how a session's value is shown; `value`: what
 * it is sorted by, if that is not what is shown; `text`: stands at the left, and is shown in full on hover.
 */
export const COLUMNS = [
  {name: 'Hand', hint: 'number of the session', wide: 9, rank: 0, write: (s) => `${s.number}`, value: (s) => s.number},
  {name: 'Client', hint: 'name that the token gives', wide: 13, rank: 1, text: true, write: (s) => words.middle(s.client ?? '–', NAME_MOST), full: (s) => s.client ?? ''},
  {name: 'Device', hint: '', wide: 11, rank: 6, text: true, write: (s) => words.middle(s.device ?? '–', NAME_MOST), full: (s) => s.device ?? ''},
  {name: 'Force', hint: 'rendered by the device now', wide: 10, rank: 2, write: (s, hand) => (hand ? words.force(hand.rendered) : '–'), value: (s, hand) => hand?.rendered},
  {name: 'Bounded by', hint: 'why less force is rendered than the scene asks for; the strip says it in words', wide: 19, rank: 3, text: true, write: (s, hand, reasons) => bounds(hand, reasons) || '–'},
  {name: 'Round trip', hint: 'of a sample and its reply', wide: 11, rank: 4, write: (s) => words.number(s.round_trip_ms, 1, 'ms'), value: (s) => s.round_trip_ms},
  {name: 'Late', hint: 'servo ticks that came a whole period late or more', wide: 8, rank: 8, write: (s) => count(s.late_ticks), value: (s) => s.late_ticks},
  {name: 'Loss', hint: 'of datagrams', wide: 8, rank: 5, write: (s) => words.percent(s.loss ?? null), value: (s) => s.loss},
  {name: 'Energy given', hint: 'energy given to the hand; negative: the hand gave energy to the device', wide: 13, rank: 9, write: (s) => words.energy(s.delivered_j), value: (s) => s.delivered_j},
  {name: 'Servo', hint: 'rate of the device', wide: 9, rank: 10, write: (s) => words.number(s.rate_hz, 0, 'Hz'), value: (s) => s.rate_hz},
  {name: 'Packets', hint: 'rate of datagrams', wide: 9, rank: 11, write: (s) => words.number(s.packet_hz, 0, 'Hz'), value: (s) => s.packet_hz},
  {name: 'Mode', hint: 'how forces are bounded', wide: 27, rank: 7, text: true, write: (s) => [s.mode, s.side && `at the ${s.side}`].filter(Boolean).join(', ') || '–'},
  {name: 'Samples', hint: 'since the session began', wide: 11, rank: 13, write: (s) => count(s.samples), value: (s) => s.samples},
  {name: 'Time', hint: 'since the session began', wide: 8, rank: 12, write: (s) => words.duration(s.seconds), value: (s) => s.seconds},
];

/**
 * @param {number} room [letters] of the table; infinite: as many as a card has
 * @param {Map<string, boolean>} chosen by the user: columns that are always or never there; the others are there while they fit
 * @returns {boolean[]} for each column, whether it is shown
 */
export function columnsThatFit(room, chosen) {
  const shown = COLUMNS.map(({name}) => chosen.get(name) === true);
  let left = room - COLUMNS.reduce((sum, {wide}, i) => sum + (shown[i] ? wide : 0), 0);
  const others = COLUMNS.map((column, i) => ({...column, i})).filter(({name}) => !chosen.has(name)).sort((a, b) => a.rank - b.rank);
  for (const {wide, i} of others) {
    if (wide > left) break;
    shown[i] = true;
    left -= wide;
  }
  return shown;
}

/** Compares two values of a column: numbers by size, names by letters, and what is unknown comes last. */
export function compare(a, b) {
  const [known, other] = [a, b].map((value) => value !== null && value !== undefined && value !== '–');
  if (!known || !other) return Number(other) - Number(known);
  return typeof a === 'number' && typeof b === 'number' ? a - b : String(a).localeCompare(String(b), 'en', {numeric: true});
}
