// Says in words why a hand feels what it feels.

import {hasText, say} from './language.js';
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
    const beside = hand.commanded < TOUCH ? '' : say('why.beside', {force: words.force(hand.commanded)});
    return say('why.robot', {force: words.force(hand.rendered)}) + beside;
  }
  if (hand.commanded < TOUCH && hand.rendered < TOUCH) return say('why.free');
  if (hand.commanded < TOUCH) return say('why.rest', {force: words.force(hand.rendered)});
  const where = hand.floats[AT.depth] > 0 ? say('why.depth', {depth: words.depth(hand.floats[AT.depth])}) : '';
  const share = hand.rendered / hand.commanded;
  const held = (text) => say('why.held', {where, asked: words.force(hand.commanded), held: words.force(hand.rendered), share: text});
  if (share > 0.98 && share < 1.02) return held(say('why.all'));
  if (share < 1) return held(say('why.part', {share: Math.round(100 * share)}));
  // Both forces are of one picture, but not of one position.
  const cause = say(near ? 'why.newer' : 'why.older');
  return held(share > MANY ? say('why.far', {times: MANY, cause}) : say('why.above', {share: Math.round(100 * share), cause}));
}

/**
 * @param {import('./hands.js').Hand} hand @param {{hand_damping?: number | null} | undefined} session
 * @param {number} smallDebt [J] below which none is named @returns {string} what its bound counts on
 */
export function accounted(hand, session, smallDebt) {
  const owed = -hand.floats[AT.room];
  const debt = owed > smallDebt ? say('why.debt', {energy: words.energy(owed)}) : '';
  const damping = session?.hand_damping > 0 ? say('why.damping', {damping: words.number(session.hand_damping, 2, 'N s/m')}) : '';
  return debt + damping;
}

/** A reason in the language of the page. Servers that are newer than the page may have others: they say them in English. */
function reasonText({name, text}, before) {
  const again = before.filter((reason) => reason.name === name).length;
  const key = `reason.${name}${again > 0 ? `.${again + 1}` : ''}`;
  return hasText(key) ? say(key) : text;
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
    this.items = reasons.map((reason, bit) => {
      const [item, text, share] = ['li', 'span', 'b'].map((tag) => document.createElement(tag));
      text.textContent = reasonText(reason, reasons.slice(0, bit));
      item.title = reason.name;
      item.hidden = true;
      item.classList.toggle('state', reason.cuts === false);
      item.append(text, ' ', share);
      return {item, share};
    });
    // Reasons that take force off come first: the strip has room for two.
    const inOrder = (cuts) => this.items.filter((_, bit) => (reasons[bit].cuts !== false) === cuts).map(({item}) => item);
    this.list.append(...inOrder(true), ...inOrder(false));
  }

  /** @param {import('./hands.js').Hand | undefined} hand @param {boolean} seen whether any picture came @param {object | undefined} session of the hand */
  show(hand, seen, session) {
    const active = hand?.activeReasons() ?? [];
    const does = {movesRobot: active.includes(this.moving), near: active.includes(this.near)};
    const said = (hand ? sentence(hand, does) + accounted(hand, session, this.smallDebt) : say(seen ? 'scene.empty' : 'why.nothing'));
    this.#write(this.text, said);
    if (this.text.title !== said) this.text.title = said;  // Where it is cut.
    this.items.forEach(({item, share}, bit) => {
      item.hidden = !active.includes(bit);
      if (!item.hidden) this.#write(share, say('why.share', {share: Math.max(1, Math.round(100 * hand.share[bit]))}));
    });
  }

  #write(element, text) {
    if (element.textContent !== text) element.textContent = text;
  }
}
