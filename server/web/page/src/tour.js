// The guided tour: the paper, played live. Each step gives a hand another law, or the network another delay, and measures what comes of it.

import {make} from './elements.js';
import {say} from './language.js';
import {drawFigure, FIGURES} from './tour_figure.js';
import {lawName, STEPS, wallOf} from './tour_laws.js';
import {pressAndSlide, Trace} from './tour_motion.js';
import * as words from './words.js';

const SECONDS = 4;  // of the figure, and from which is measured
const SETTLED = 2.5;  // [s] after the hand was taken, or the delay was changed
const WRITE_PERIOD = 250;  // [ms]
const SUNK = 0.008;  // [m] in the wall where a hand without force has sunk through it
const LIFT = 2000;  // [ms] for which it is held above the wall then: its device burns what its account lacks
const LIFTS = 2;  // of one hand, then the tour takes another
const PER_NEWTON = 0.005;  // [m] of arrow: what this scene asks for would make others invisible
const COLUMNS = ['shakes', 'deepest', 'felt', 'off'];

export class Tour {
  /**
   * @param {HTMLElement} panel
   * @param {{own: import('./own_hand.js').OwnHand, hands: import('./hands.js').Hands, sessions: () => Map<number, object>, admin: () => boolean,
   *          send: (message: object) => void, choose: (number: number) => void, unlock: () => void, close: () => void, scale: (perNewton: number | null) => void}} page
   *   `unlock` shows where an admin's token goes; `scale` sets how long arrows are, null: they scale by themselves
   */
  constructor(panel, page) {
    this.panel = panel;
    this.page = page;
    this.wall = null;
    this.name = '';  // of the scene
    this.colors = null;
    this.active = false;
    this.step = 0;
    this.law = null;  // that is wanted; null: no hand of the page
    this.holds = null;  // the law of the hand that it took
    this.asked = false;  // whether that hand was asked for
    this.delayed = new Set();  // sessions whose links it has changed
    this.delay = null;  // [s] that they have by now
    this.moves = !matchMedia('(prefers-reduced-motion: reduce)').matches;  // whether it moves the hand by itself
    this.since = 0;  // [s] of the pictures, from when it is measured
    this.heldAt = 0;  // [ms] from when it is moved
    this.lifted = false;
    this.lifts = 0;  // of this hand
    this.trace = new Trace(SECONDS);
    this.before = null;  // the trace of the step before
    this.results = new Map();  // name -> measured
    this.kept = new Map();  // name -> the trace that was measured
    this.watched = null;
    this.written = 0;
  }

  /** @param {object} scene the server's message */
  scene(scene) {
    this.wall = wallOf(scene);
    this.results.clear();
    this.kept.clear();
    this.before = null;
    this.trace.clear();
    if (scene.name !== this.name) this.delayed.clear();  // After a reload the delays are still there, and are set back later.
    this.name = scene.name;
    if (this.active) this.go(this.step);
  }

  paint(colors) {
    this.colors = colors;
  }

  /** The panel was opened, or closed. */
  show(active) {
    this.active = active;
    if (this.panel.childElementCount === 0) this.#build();
    this.page.scale(active ? PER_NEWTON : null);
    if (active) {
      this.go(this.step);
      this.title.focus({preventScroll: true});
    } else this.#leave();
  }

  /** @param {number} step of STEPS */
  go(step) {
    this.step = Math.min(Math.max(step, 0), STEPS.length - 1);
    const {name, laws, delay} = STEPS[this.step];
    this.title.textContent = say(`tour.${name}.title`);
    this.place.textContent = say('tour.place', {step: this.step + 1, steps: STEPS.length});
    this.back.disabled = this.step === 0;
    this.next.disabled = this.step === STEPS.length - 1;
    this.choices.replaceChildren(...(laws?.length > 1 ? laws : []).map((law) => make('button', {onclick: () => this.#take(law)}, say(`tour.law.${lawName(law)}`))));
    this.#begin();
    if (delay === undefined) this.#setDelay(0);
    if (laws) this.#take(laws[0]);
    else this.#watchDelayed(delay);
    this.#write();
  }

  /** Once a frame. @param {number} now [ms] */
  run(now) {
    if (!this.active) return;
    const {own} = this.page;
    if (this.law !== null && this.wall) this.#keepHand(now);
    else if (own.state === 'held' && this.holds !== null) this.#letGo();
    const hand = this.page.hands.all.get(this.#number());
    if (hand && this.wall) {
      if (this.watched !== hand.number) this.#begin(hand);
      this.trace.add(hand, this.wall);
    }
    if (own.state === 'held' && this.moves && this.wall && this.law !== null && this.holds === this.law) this.#lead(now, hand);
    if (now - this.written < WRITE_PERIOD) return;
    this.written = now;
    if (STEPS[this.step].delay !== undefined) this.#watchDelayed(STEPS[this.step].delay);
    this.#measure(hand);
    this.#write();
    if (this.colors) drawFigure(this.figure, this.colors, this.#figureName(), (of) => ({now: this.trace, before: this.before}[of] ?? this.kept.get(of) ?? null));
  }

  /** The user moves the hand: the tour does not. */
  yield() {
    this.moves = false;
  }

  /** For tests. */
  look() {
    return {active: this.active, step: this.step, law: this.law, holds: this.holds, moves: this.moves, rows: this.trace.rows.length, figure: FIGURES[this.#figureName()].map(({title}) => title), delay: this.delay, results: Object.fromEntries(this.results)};
  }

  #build() {
    this.title = make('h3', {tabIndex: -1, id: 'tour-title'});
    this.text = make('p', {id: 'tour-text'});
    this.equation = make('p', {className: 'equation'});
    this.choices = make('p', {className: 'choices', role: 'group', ariaLabel: say('tour.laws')});
    this.figure = make('canvas', {role: 'img'});
    this.caption = make('p', {className: 'caption'});
    this.said = make('p', {role: 'status', id: 'tour-said'});
    this.again = make('button', {onclick: () => this.#again()});
    this.unlock = make('button', {onclick: () => this.page.unlock()}, say('tour.unlock'));
    this.auto = make('button', {onclick: () => this.#move(!this.moves)}, say('tour.moves'));
    this.place = make('span', {className: 'place'});
    this.back = make('button', {onclick: () => this.#turn(-1)}, say('tour.back'));
    this.next = make('button', {onclick: () => this.#turn(1)}, say('tour.next'));
    this.table = make('table');
    this.table.createTHead().insertRow().append(...['law', ...COLUMNS].map((name) => (
      make('th', {scope: 'col', title: say(`tour.column.${name}.hint`)}, say(`tour.column.${name}`)))));
    this.body = this.table.createTBody();
    const close = make('button', {onclick: () => this.page.close(), title: say('tour.close'), ariaLabel: say('tour.close')}, '×');
    this.panel.append(make('header', {}, make('h2', {}, say('tour.name')), close), make('p', {className: 'steps'}, this.back, this.place, this.next), this.title, this.text, this.equation, this.choices,
      make('p', {className: 'acts'}, this.said, this.again, this.unlock, this.auto), this.figure, this.caption, this.table);
  }

  #turn(step) {
    this.go(this.step + step);
    this.title.focus();
  }

  #take(law) {
    this.law = law;
    this.asked = false;
    for (const button of this.choices.children) button.setAttribute('aria-pressed', String(button.textContent === say(`tour.law.${lawName(law)}`)));
    this.#write();
  }

  /** What was let go is taken again. */
  #again() {
    this.asked = false;
  }

  #move(moves) {
    this.moves = moves;
    this.heldAt = performance.now();
    this.#write();
  }

  /** Lets go of a hand with another law, and takes one with the law that is wanted. */
  #keepHand(now) {
    const {own} = this.page;
    if (own.state === 'held' && this.holds !== this.law) this.#letGo();
    if (own.state === 'free' && !this.asked) {
      this.asked = true;
      this.holds = this.law;
      own.begin(this.law);
    }
    if (own.state !== 'held') this.heldAt = now;
  }

  /** Presses and slides. A machine that is too busy may leave the account of the hand empty: then it is lifted, and begins again. */
  #lead(now, hand) {
    const last = this.trace.rows.at(-1);
    this.lifted = now < this.heldAt;
    if (hand && last && !this.lifted && last.depth > SUNK && last.held < 0.1) {
      this.lifts += 1;
      if (this.lifts > LIFTS) return this.#letGo();  // Its account is in a debt for good: take another hand.
      this.heldAt = now + LIFT;
      this.since = hand.time + LIFT / 1000 + SETTLED;
    }
    this.page.own.lead(pressAndSlide(this.wall, this.page.own.start, Math.max(now - this.heldAt, 0) / 1000));
  }

  #letGo() {
    this.page.own.release();
    this.asked = false;
    this.holds = null;
  }

  /** The hand whose trace is measured. @returns {number | null} */
  #number() {
    const {laws, model} = STEPS[this.step];
    if (laws) return this.holds === this.law ? this.page.own.number : null;
    return this.#linked().find((session) => session.local_model === model)?.number ?? null;
  }

  /** Sessions whose clients take another link. */
  #linked() {
    return [...this.page.sessions().values()].filter(({link_taken: taken}) => taken);
  }

  /** Delays the hands whose clients take that, if this page may. */
  #watchDelayed(delay) {
    this.law = null;
    this.asked = false;
    if (this.page.admin()) this.#setDelay(delay);
  }

  /** @param {number} delay [s] each way; of none, those that the tour has delayed are set back */
  #setDelay(delay) {
    const sessions = this.#linked().map(({session}) => session).filter((session) => (delay > 0 ? this.delay !== delay || !this.delayed.has(session) : this.delayed.has(session)));
    for (const session of sessions) {
      this.page.send({set: {session, link_delay: delay}});
      this.delayed.add(session);
    }
    if (sessions.length > 0) this.#begin();
    if (delay === 0) this.delayed.clear();
    this.delay = delay;
  }

  #leave() {
    if (this.holds !== null) this.#letGo();
    this.law = null;
    this.#setDelay(0);
  }

  /** Another hand, law or delay is measured from now on. @param {import('./hands.js').Hand} [hand] */
  #begin(hand) {
    if (this.trace.span > 1) {
      this.before = this.trace;
      this.trace = new Trace(SECONDS);
    }
    this.trace.clear();
    this.watched = hand?.number ?? null;
    this.lifts = 0;
    this.since = (hand?.time ?? 0) + SETTLED;
    if (hand) this.page.choose(hand.number);
  }

  #measure(hand) {
    if (!hand || this.watched !== hand.number || this.trace.end < this.since + SECONDS / 2) return;
    const {laws, name} = STEPS[this.step];
    if (!laws && this.delay !== STEPS[this.step].delay) return;
    const {depth, ...others} = this.trace.measured(this.since);
    // The scene asks a delayed hand for the force of an older place, and a hand that taps moves as fast as one that shakes.
    this.results.set(laws ? `law.${lawName(this.law)}` : `hand.${name}`, {depth, ...(laws && others)});
    this.kept.set(laws ? lawName(this.law) : name, this.trace.copy());
  }

  /** Steps with several laws have a figure for each. */
  #figureName() {
    const {name, laws} = STEPS[this.step];
    return laws?.length > 1 ? lawName(this.law ?? laws[0]) : name;
  }

  /** @returns {string} what keeps this step from acting; empty: nothing */
  #locked() {
    const {laws} = STEPS[this.step];
    if (!this.wall) return say('tour.locked.scene');
    if (laws) return this.page.own.state === 'none' ? say('tour.locked.hand') : '';
    if (this.#linked().length === 0) return say('tour.locked.demo');
    return this.page.admin() ? '' : say('tour.locked.admin');
  }

  #state() {
    const {own} = this.page;
    if (this.law === null) return say('tour.delayed', {delay: words.number(1000 * this.delay, 0, 'ms')});
    if (own.state === 'held') return say(!this.moves ? 'tour.yours' : this.lifted ? 'tour.lifted' : 'tour.leads');
    return own.state === 'free' && this.asked && this.holds === this.law ? own.page.text.textContent || say('tour.joining') : say('tour.joining');
  }

  #write() {
    const {name, laws} = STEPS[this.step];
    const {own} = this.page;
    const locked = this.#locked();
    const lawful = this.law === null ? name : `law.${lawName(this.law)}`;
    const put = (element, text) => {
      if (element.textContent !== text) element.textContent = text;
      element.hidden = text === '';
    };
    put(this.text, say(laws?.length > 1 ? `tour.${lawful}.text` : `tour.${name}.text`));
    put(this.equation, laws ? say(`tour.${lawful}.equation`) : '');
    put(this.said, locked || this.#state());
    this.said.classList.toggle('locked', locked !== '');
    this.unlock.hidden = !(locked && !laws && this.wall && this.#linked().length > 0);
    this.again.hidden = !(!locked && this.law !== null && own.state === 'free' && this.asked);
    this.again.textContent = say('tour.again');
    this.auto.hidden = !(own.state === 'held' && this.law !== null);
    this.auto.setAttribute('aria-pressed', String(this.moves));
    put(this.caption, say(laws?.length > 1 ? `tour.law.${this.#figureName()}.caption` : `tour.${name}.caption`));
    this.figure.setAttribute('aria-label', `${say('tour.figure')} ${this.caption.textContent}`);
    this.#writeTable();
  }

  #writeTable() {
    const rows = [...this.results].map(([name, {shakes, depth, share, off}]) => [
      say(`tour.row.${name}`), words.number(1e6 * shakes, 0, 'µm'), words.depth(depth), words.number(100 * share, 0, '%'), words.number(off, 0, '°'),
    ]);
    while (this.body.rows.length > rows.length) this.body.deleteRow(-1);
    rows.forEach((texts, i) => {
      const row = this.body.rows[i] ?? this.body.insertRow();
      while (row.cells.length < texts.length) row.insertCell();
      texts.forEach((text, k) => row.cells[k].textContent !== text && (row.cells[k].textContent = text));
    });
    this.table.hidden = rows.length === 0;
  }
}
