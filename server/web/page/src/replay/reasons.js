// Why a hand was given no force: the names of the numbers of feltwire.Account.NoForce.

/** Each has a text, `recorded.` and its name. */
export const REASONS = [
  'felt', 'observer', 'device_ended', 'ending', 'device_fault', 'no_reply', 'reconnecting', 'silent', 'recovering',
  'server_bound', 'touches_nothing', 'too_little', 'not_actuated', 'waiting', 'refused', 'bound', 'velocity_limit',
  'ramp', 'slew', 'force_limit', 'account', 'not_held', 'law_change', 'clutched', 'not_homed', 'in_inkwell',
  'starting', 'emergency', 'jumped', 'overdrawn', 'not_moved',
];

export const FELT = 0;
export const OBSERVER = 1;

/** What the strip tells apart. Each has a color of the theme, and a text, `class.` and its name. */
export const CLASSES = [
  {name: 'force', color: 'rendered'},
  {name: 'cut', color: 'friction'},
  {name: 'kept', color: 'limit'},
  {name: 'nothing', color: 'line'},
];
const NOTHING = new Set(['observer', 'device_ended', 'ending', 'no_reply', 'touches_nothing', 'too_little', 'clutched'].map((name) => REASONS.indexOf(name)));

/** @param {number} reason of an account @param {number} cut share that the account took off @returns {number} place in CLASSES */
export function classOf(reason, cut) {
  if (reason !== FELT) return NOTHING.has(reason) ? 3 : 2;
  return cut > 0.005 ? 1 : 0;
}
