// Numbers with units, in words that fit a table or a label.

const unknown = '–';

/** @param {number | null | undefined} value @param {number} digits @param {string} [unit] */
export function number(value, digits, unit = '') {
  if (value === null || value === undefined || !Number.isFinite(value)) return unknown;
  return value.toFixed(digits).replace('-', '−') + (unit && ` ${unit}`);
}

/** @param {number} newtons */
export const force = (newtons) => number(newtons, newtons < 10 ? 2 : 1, 'N');

/** @param {number} metres */
export const depth = (metres) => number(1000 * metres, Math.abs(metres) < 0.01 ? 2 : 1, 'mm');

/** @param {number | null} joules */
export function energy(joules) {
  if (joules === null || joules === undefined || !Number.isFinite(joules)) return unknown;
  return Math.abs(joules) < 1 ? number(1000 * joules, Math.abs(joules) < 0.01 ? 2 : 0, 'mJ') : number(joules, 2, 'J');
}

/** @param {number | null} share 0..1 */
export const percent = (share) => number(share === null ? null : 100 * share, 1, '%');

/** @param {number | null} seconds */
export function duration(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return unknown;
  if (seconds < 120) return number(seconds, 0, 's');
  return seconds < 7200 ? number(seconds / 60, 0, 'min') : number(seconds / 3600, 1, 'h');
}

/** 75.1234 is 1:15.123. @param {number} seconds */
export function clock(seconds) {
  const size = Math.round(1000 * Math.abs(seconds));
  const rest = ((size % 60000) / 1000).toFixed(3).padStart(6, '0');
  return `${seconds < 0 && size > 0 ? '−' : ''}${Math.floor(size / 60000)}:${rest}`;
}

/** @param {number} metres a length of the scene, such as a grid's step */
export function distance(metres) {
  if (metres < 0.01) return `${+(1000 * metres).toPrecision(3)} mm`;
  return metres < 1 ? `${+(100 * metres).toPrecision(3)} cm` : `${+metres.toPrecision(3)} m`;
}

/** @param {number} value positive @returns {number} the nearest of 1, 2 and 5 times a power of ten, not above it */
export function roundDown(value) {
  const power = 10 ** Math.floor(Math.log10(value) + 1e-9);
  const digit = value / power;
  return power * (digit >= 5 - 1e-9 ? 5 : digit >= 2 - 1e-9 ? 2 : 1);
}

/** @param {number} value one of 1, 2, 5 times a power of ten @param {number} steps up or down that series */
export function stepped(value, steps) {
  let result = roundDown(value);
  for (; steps > 0; --steps) result = roundDown(result * 2.5);
  for (; steps < 0; ++steps) result = roundDown(result / 1.9);
  return result;
}

/** @param {string} text @param {number} room @param {(text: string) => number} widthOf a text, in the units of `room` @returns {string} as much of the text as fits, without its middle */
export function fitting(text, room, widthOf) {
  if (widthOf(text) <= room) return text;
  let [least, most] = [2, [...text].length];  // letters: what fits, and what does not
  while (most - least > 1) {
    const half = (least + most) >> 1;
    if (widthOf(middle(text, half)) <= room) least = half;
    else most = half;
  }
  return middle(text, least);
}

/** @param {string} text @param {number} most letters @returns {string} the text; a longer one without its middle, since names often differ at the end */
export function middle(text, most) {
  const letters = [...text];
  if (letters.length <= most) return text;
  const end = Math.floor((most - 1) / 2);
  return `${letters.slice(0, most - 1 - end).join('')}…${letters.slice(-end).join('')}`;
}
