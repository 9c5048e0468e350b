// Checks that the mock server's messages have the members of a real server's. A server test reads the same members.json.

import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';

const agreed = JSON.parse(readFileSync(new URL('members.json', import.meta.url), 'utf8'));

/** @type {{name: string, text: string, cuts: boolean}[]} by the bit of a hand's reasons */
export const REASONS = agreed.reasons;

/** @param {...string} names of reasons @returns {number} their bits; of two that have one name, the client's */
export const bits = (...names) => names.reduce((sum, name) => {
  const bit = REASONS.findLastIndex((reason) => reason.name === name);
  assert.ok(bit >= 0, `${name} is no reason`);
  return sum | 1 << bit;
}, 0);

/** Throws if a message has other members than the server's. @param {object} message */
export function checkMembers(message, where = message.type) {
  const entries = agreed.members[where];
  assert.ok(entries, `no server sends ${where}`);
  const [may, must] = [entries.map((name) => name.replace('?', '')), entries.filter((name) => !name.endsWith('?'))];
  for (const name of Object.keys(message)) assert.ok(may.includes(name), `no server sends ${where}.${name}`);
  for (const name of must) assert.ok(name in message, `${where}.${name} is missing`);
  for (const [name, value] of Object.entries(message)) {
    if (agreed.members[`${where}.${name}`]) for (const entry of value) checkMembers(entry, `${where}.${name}`);
  }
}
