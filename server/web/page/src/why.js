// Says in words why a hand feels what it feels.

import {AT} from './messages.js';
import * as words from './words.js';

const TOUCH = 1e-3;  // [N]
const MANY = 3;  // times the force of the scene from which no percentage is said

/**
 * @param {import('./hands.js').Hand} hand @param {{movesRobot?: boolean, near?: boolean}} does whether it feels what its robot touches, and
 *   whether its client computes the force from a local model
 * @returns {string} one sentence on what the hand does and feels
 */
export function sentence(hand, {movesRobot = false, near = false} = {}) {
  if (movesRobot) {
    const beside = hand.commanded < TOUCH ? '' : ` The scene asks for ${words.force(hand.commanded)} beside.`;
    return `It moves a robot and feels what the robot touches: the device renders ${words.force(hand.rendered)}.${beside}`;
  }
  if (hand.commanded < TOUCH && hand.rendered < TOUCH) return 'It moves freely and touches nothing.';
  if (hand.commanded < TOUCH) return `The scene asks for no force, but the device still holds ${words.force(hand.rendered)}.`;
  const where = hand.floats[AT.depth] > 0 ? `It presses ${words.depth(hand.floats[AT.depth])} deep. ` : '';
  const share = hand.rendered / hand.commanded;
  const held = `The scene asks for ${words.force(hand.commanded)}, and the device renders ${words.force(hand.rendered)}`;
  if (share > 0.98 && share < 1.02) return `${where}${held}: all of it.`;
  if (share < 1) return `${where}${held}: ${Math.round(100 * share)} %.`;
  // Both forces are of one picture, but not of one position.
  const size = share > MANY ? `more than ${MANY} times as much` : `${Math.round(100 * share)} %`;
  return `${where}${held}: ${size}, because ${near ? 'its client computes the force by itself, at a newer position' : 'the device still answers an earlier position'}.`;
}

/**
 * @param {import('./hands.js').Hand} hand @param {{hand_damping?: number | null} | undefined} session
 * @param {number} smallDebt [J] below which none is named @returns {string} what its bound counts on
 */
export function accounted(hand, session, smallDebt) {
  const owed = -hand.floats[AT.room];
  const debt = owed > smallDebt ? ` Its account is short of ${words.energy(owed)}.` : '';
  const damping = session?.hand_damping > 0 ? ` Its shaping counts on ${words.number(session.hand_damping, 2, 'N s/m')} of the hand itself.` : '';
  return debt + damping;
}

/** The strip below the scene. Elements are made once for each reason and then shown or hidden. */
export class Why {
  /** @param {HTMLElement} text for the sentence @param {HTMLElement} list for the reasons */
  constructor(text, list) {
    this.text = text;
    this.list = list;
    this.items = [];
    this.smallDebt = 0;
    this.moving = -1;  // the reason of a hand that moves a robot, and of one whose client has a local model
    this.near = -1;
  }

  /** @param {{reasons?: {name: string, text: string, cuts?: boolean}[], small_debt?: number}} hello of the server; cuts: it takes force off */
  hello({reasons = [], small_debt: smallDebt = 0}) {
    this.smallDebt = smallDebt;
    this.list.replaceChildren();
    this.moving = reasons.findIndex(({name}) => name === 'moves_robot');
    this.near = reasons.findIndex(({name}) => name === 'near');
    this.items = reasons.map((reason) => {
      const [item, text, share] = ['li', 'span', 'b'].map((tag) => document.createElement(tag));
      text.textContent = reason.text;
      item.title = reason.name;
      item.hidden = true;
      item.classList.toggle('state', reason.cuts === false);
      item.append(text, ' ', share);
      this.list.append(item);
      return {item, share};
    });
  }

  /** @param {import('./hands.js').Hand | undefined} hand @param {boolean} seen whether any picture came @param {object | undefined} session of the hand */
  show(hand, seen, session) {
    const active = hand?.activeReasons() ?? [];
    const does = {movesRobot: active.includes(this.moving), near: active.includes(this.near)};
    const said = (hand ? sentence(hand, does) + accounted(hand, session, this.smallDebt) : seen ? 'No hand is in this scene yet.' : 'Nothing has come from the server yet.');
    this.#write(this.text, said);
    if (this.text.title !== said) this.text.title = said;  // Where it is cut.
    this.items.forEach(({item, share}, bit) => {
      item.hidden = !active.includes(bit);
      if (!item.hidden) this.#write(share, `${Math.max(1, Math.round(100 * hand.share[bit]))} % of the time`);
    });
  }

  #write(element, text) {
    if (element.textContent !== text) element.textContent = text;
  }
}
