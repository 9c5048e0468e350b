// Why a hand was given no force: the numbers of feltwire.Account.NoForce, their names and what they mean.

/** @type {[string, string][]} */
export const REASONS = [
  ['felt', 'The hand is given force.'],
  ['observer', 'An observer is given no force.'],
  ['device_ended', 'The recorded movement is over.'],
  ['ending', 'The run ends, and the hand is let go.'],
  ['device_fault', 'The device gives no usable position.'],
  ['no_reply', 'The server has not answered yet.'],
  ['reconnecting', 'The session has just been found again.'],
  ['silent', 'There is no fresh answer from the server.'],
  ['recovering', 'The server has put back what moves.'],
  ['server_bound', 'The server\'s energy bound lets none through.'],
  ['touches_nothing', 'The hand touches nothing.'],
  ['too_little', 'The scene asks for less than 0.005 N.'],
  ['not_actuated', 'The device cannot give what the scene asks for.'],
  ['waiting', 'The force waits: the hand has to move out of contact first.'],
  ['refused', 'The command or the movement was beyond every limit.'],
  ['bound', 'The energy bound lets none through.'],
  ['velocity_limit', 'The hand is faster than --velocity-limit allows.'],
  ['ramp', '--ramp-up has just begun.'],
  ['slew', '--slew lets the force rise slowly.'],
  ['force_limit', '--max-force allows less than 0.005 N.'],
  ['account', 'The device has not burned enough energy for it.'],
  ['not_held', 'The device does not hold what it is given.'],
  ['law_change', 'An admin has just given the session another law.'],
  ['clutched', 'The clutch is held: the hand moves without the tool.'],
  ['not_homed', 'The device must be homed first.'],
  ['in_inkwell', 'The stylus is in its inkwell.'],
  ['starting', 'The hand is not still yet, or the weight of the tool is being taken up.'],
  ['emergency', 'The emergency stop was pressed.'],
  ['jumped', 'The position of the device jumped farther than a hand can move.'],
  ['overdrawn', 'The hand got more energy than the device had burned, so the force has ended.'],
  ['not_moved', 'The program that moves the hand has given no new position for too long.'],
];

export const FELT = 0;
export const OBSERVER = 1;

/** What the strip tells apart. Each has a color of the theme. */
export const CLASSES = [
  {name: 'force', color: 'rendered', text: 'the hand is given force'},
  {name: 'cut', color: 'friction', text: 'the energy account takes a part of it'},
  {name: 'kept away', color: 'limit', text: 'the scene asks for force, and the hand is given none'},
  {name: 'nothing', color: 'line', text: 'there is no force to be given'},
];
const NOTHING = new Set(['observer', 'device_ended', 'ending', 'no_reply', 'touches_nothing', 'too_little', 'clutched'].map((name) => REASONS.findIndex((entry) => entry[0] === name)));

/** @param {number} reason of an account @param {number} cut share that the account took off @returns {number} place in CLASSES */
export function classOf(reason, cut) {
  if (reason !== FELT) return NOTHING.has(reason) ? 3 : 2;
  return cut > 0.005 ? 1 : 0;
}
