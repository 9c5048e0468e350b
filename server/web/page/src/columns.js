// Columns of the table of hands: what each says, how wide it is, and what it is sorted by.

import {say} from './language.js';
import * as words from './words.js';

const count = (value) => (value ?? '–').toLocaleString('en');

/** Names of the reasons that take force off a hand now. */
const bounds = (hand, reasons) => [...new Set(hand?.activeReasons().map((bit) => reasons[bit]).filter((reason) => reason && reason.cuts !== false)
  .map((reason) => reason.name).sort())].join(', ');

/**
 * `id`: what the browser keeps a choice by. `wide`: [letters] at least. `rank`: the lower, the longer it stays in a narrow table. `write`: how a session's value is shown; `value`: what
 * it is sorted by, if that is not what is shown; `text`: stands at the left, loses its middle where the column is narrow, and is shown in full on hover.
 */
export const COLUMNS = [
  {id: 'hand', name: say('column.hand'), hint: say('column.hand.hint'), wide: 9, rank: 0, write: (s) => `${s.number}`, value: (s) => s.number},
  {id: 'client', name: say('column.client'), hint: say('column.client.hint'), wide: 13, rank: 1, text: true, write: (s) => s.client ?? '–'},
  {id: 'device', name: say('column.device'), hint: '', wide: 11, rank: 6, text: true, write: (s) => s.device ?? '–'},
  {id: 'force', name: say('column.force'), hint: say('column.force.hint'), wide: 10, rank: 2, write: (s, hand) => (hand ? words.force(hand.rendered) : '–'), value: (s, hand) => hand?.rendered},
  {id: 'bounds', name: say('column.bounds'), hint: say('column.bounds.hint'), wide: 19, rank: 3, text: true, write: (s, hand, reasons) => bounds(hand, reasons) || '–'},
  {id: 'trip', name: say('column.trip'), hint: say('column.trip.hint'), wide: 11, rank: 4, write: (s) => words.number(s.round_trip_ms, 1, 'ms'), value: (s) => s.round_trip_ms},
  {id: 'late', name: say('column.late'), hint: say('column.late.hint'), wide: 8, rank: 8, write: (s) => count(s.late_ticks), value: (s) => s.late_ticks},
  {id: 'loss', name: say('column.loss'), hint: say('column.loss.hint'), wide: 8, rank: 5, write: (s) => words.percent(s.loss ?? null), value: (s) => s.loss},
  {id: 'energy', name: say('column.energy'), hint: say('column.energy.hint'), wide: 13, rank: 9, write: (s) => words.energy(s.delivered_j), value: (s) => s.delivered_j},
  {id: 'servo', name: say('column.servo'), hint: say('column.servo.hint'), wide: 9, rank: 10, write: (s) => words.number(s.rate_hz, 0, 'Hz'), value: (s) => s.rate_hz},
  {id: 'packets', name: say('column.packets'), hint: say('column.packets.hint'), wide: 9, rank: 11, write: (s) => words.number(s.packet_hz, 0, 'Hz'), value: (s) => s.packet_hz},
  {id: 'mode', name: say('column.mode'), hint: say('column.mode.hint'), wide: 27, rank: 7, text: true, write: (s) => (s.mode && s.side ? say('column.mode.side', s) : s.mode ?? '–')},
  {id: 'samples', name: say('column.samples'), hint: say('column.samples.hint'), wide: 11, rank: 13, write: (s) => count(s.samples), value: (s) => s.samples},
  {id: 'time', name: say('column.time'), hint: say('column.time.hint'), wide: 8, rank: 12, write: (s) => words.duration(s.seconds), value: (s) => s.seconds},
];

/**
 * @param {number} room [letters] of the table; infinite: as many as a card has
 * @param {Map<string, boolean>} chosen by the user: columns that are always or never there; the others are there while they fit
 * @returns {boolean[]} for each column, whether it is shown
 */
export function columnsThatFit(room, chosen) {
  const shown = COLUMNS.map(({id}) => chosen.get(id) === true);
  let left = room - COLUMNS.reduce((sum, {wide}, i) => sum + (shown[i] ? wide : 0), 0);
  const others = COLUMNS.map((column, i) => ({...column, i})).filter(({id}) => !chosen.has(id)).sort((a, b) => a.rank - b.rank);
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
