// The viewer's own hand. It is a client of the server like any other: the page only says where it shall be, by mouse, touch, keys or
// a gamepad, and draws the spring that pulls it there.

import {Vector3} from 'three';
import {toolPlace} from './hand_view.js';
import {say} from './language.js';
import {AT, length3} from './messages.js';
import {Spring} from './spring.js';
import * as words from './words.js';

const SEND_PERIOD = 16;  // [ms] between targets that change
const STAY_PERIOD = 120;  // [ms] between targets that do not: a hand that is told nothing for a second lets go
const GRASP = 48;  // [pixels] from the hand or its target in which a drag moves it, not the camera
const PRESS = 0.005;  // [m] below the surface of a body that is dragged: the hand presses so much, and its friction takes the body along
const ON_HAND = 20;  // [pixels] from the hand in which a drag moves it also where a body is
const STEP = 0.001;  // [m] of an arrow key; ten times as much with Shift
const WHEEL = 2e-5;  // [m] for a unit of the wheel, of which a notch has some 100
const LINE = 33;  // units of the wheel, where it counts lines
const STICK_SPEED = 0.12;  // [m/s] of a gamepad's stick
const STICK_REST = 0.15;  // that a stick may show at rest
const STICK_REACH = 0.04;  // [m] that a stick moves the target away from the hand at most
const KEYS = {
  ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1],
};

const [right, upward, away, tool, projected] = Array.from({length: 5}, () => new Vector3());

export class OwnHand {
  /**
   * @param {{view: import('./view.js').View, stage: HTMLElement, button: HTMLButtonElement, law: HTMLSelectElement, text: HTMLElement, values: HTMLElement,
   *          send: (message: object) => void, found: (number: number) => void, scale: (factor: number) => void, moved: () => void}} page
   *   `found` is called when the hand's number is known, `scale` sets how depths are drawn, `moved` is called when the user moves the hand
   */
  constructor(page) {
    this.page = page;
    this.state = 'none';  // none, free, joining, held
    this.session = '';
    this.number = null;
    this.target = new Vector3();
    this.start = [0, 0, 0];  // [m] where it was taken
    this.stiffness = 0;
    this.reach = 0;
    this.sentAt = -Infinity;
    this.moved = false;
    this.pointers = new Map();  // that move the hand
    this.stepped = 0;
    this.touch = matchMedia('(pointer: coarse)');
    this.spring = new Spring();
    page.view.scene.add(this.spring.group);
    page.button.onclick = () => this.toggle();
    const {stage} = page;
    stage.addEventListener('pointerdown', (event) => this.#down(event), true);
    stage.addEventListener('pointermove', (event) => this.#move(event), true);
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) stage.addEventListener(end, (event) => this.#up(event), true);
    stage.addEventListener('wheel', (event) => this.#wheel(event), {capture: true, passive: false});
    addEventListener('keydown', (event) => this.#key(event), true);
    setInterval(() => this.#say(performance.now()), 0.5 * STAY_PERIOD);  // Where frames are rare, too.
    addEventListener('blur', () => this.release());
    document.addEventListener('visibilitychange', () => document.hidden && this.release());
  }

  /** @param {{modes?: string[]}} message the server's hello, with the laws that a hand can have */
  hello({modes = []}) {
    const {law} = this.page;
    const chosen = law.value;
    law.replaceChildren(new Option(say('head.law.usual'), ''), ...modes.map((mode) => new Option(mode)));
    if (modes.includes(chosen)) law.value = chosen;
  }

  /** Takes a hand with the chosen law, or lets it go. */
  toggle() {
    if (this.state === 'free') this.begin(this.page.law.value);
    else this.release();
  }

  /** Takes a hand, if one is free. @param {string} mode its law; empty: the usual one */
  begin(mode) {
    if (this.state !== 'free') return;
    this.page.law.value = mode;
    this.page.send({hand: 'take', ...(mode && {mode})});
  }

  /** Moves the target, for a program that moves the hand. @param {number[]} place [m] */
  lead(place) {
    this.target.fromArray(place);
    this.moved = true;
  }

  release() {
    if (this.state === 'held' || this.state === 'joining') this.page.send({hand: 'release'});
  }

  /** @param {object} message the server's `hand` */
  take(message) {
    if (message.state === 'held') {
      this.session = message.session;
      this.start = message.start;
      this.target.fromArray(message.start);
      this.stiffness = message.stiffness;
      this.reach = message.reach;
      this.moved = true;
      this.factor = this.page.view.depthFactor;
      this.page.scale(1);  // Else the spring would end beside the hand that is drawn too deep.
    }
    const said = {
      joining: say('head.joining'), held: say('own.held'), released: say('own.released', message), refused: say('own.refused', message),
    };
    this.#become({released: 'free', refused: this.state}[message.state] ?? message.state, said[message.state] ?? '');
  }

  /** The connection was lost, or another scene is shown. */
  reset() {
    this.#become('none', '');
  }

  /** @param {Map<number, object>} sessions of the server's table; finds the hand among them */
  find(sessions) {
    if (this.state !== 'held' || this.number !== null) return;
    for (const [number, {session}] of sessions) {
      if (session !== this.session) continue;
      this.number = number;
      this.page.found(number);
    }
  }

  paint(colors) {
    this.spring.paint(colors);
  }

  /** Once a frame: says where the hand shall be, and draws the spring. @param {number} now [ms] */
  step(now) {
    const elapsed = Math.min((now - this.stepped) / 1000, 0.1);
    this.stepped = now;
    if (this.state !== 'held') return;
    const {view} = this.page;
    const at = view.placeOf(this.number);
    this.#sticks(elapsed, at);
    if (this.moved) view.stale = true;
    this.#say(now);
    if (view.stale) this.spring.show(at >= 0 ? toolPlace(view.picture, at, view.depthFactor, tool) : null, this.target, view.pixel);
  }

  /** Tells the server where the hand shall be, if that is new, or if it was told long ago. */
  #say(now) {
    if (this.state !== 'held') return;
    const quiet = now - this.sentAt;
    if (quiet < (this.moved ? SEND_PERIOD : STAY_PERIOD)) return;
    this.page.send({point: this.target.toArray()});
    this.sentAt = now;
    this.moved = false;
  }

  /** The felt force in words. @param {import('./hands.js').Hand | undefined} hand */
  write(hand) {
    const {values} = this.page;
    let text = '';
    if (this.state === 'held' && hand && hand.number === this.number) {
      const stretch = this.stretch(hand);
      const pull = this.stiffness * Math.min(stretch, this.reach);
      const how = say(this.touch.matches ? 'own.fingers' : 'own.mouse');
      text = say('own.feels', {force: words.force(hand.rendered), pull: words.force(pull), stretch: words.depth(stretch), how});
    }
    if (values.textContent !== text) values.textContent = text;
  }

  /** @param {import('./hands.js').Hand} hand @returns {number} [m] from it to the target */
  stretch(hand) {
    return projected.fromArray(hand.floats, AT.position).distanceTo(this.target);
  }

  /** For tests: a copy. */
  look(hand) {
    return {
      state: this.state, number: this.number, target: this.target.toArray(), felt: hand ? length3(hand.floats, AT.rendered) : 0,
      position: hand ? [...hand.floats.subarray(AT.position, AT.position + 3)] : null, proxy: hand ? [...hand.floats.subarray(AT.proxy, AT.proxy + 3)] : null,
      depth: hand ? hand.floats[AT.depth] : 0, rods: this.spring.rods.count,
    };
  }

  #become(state, text) {
    const {view, button, law} = this.page;
    if (state !== 'held' && this.state === 'held') {
      this.page.scale(this.factor);
      this.number = null;
      this.pointers.clear();
      this.spring.show(null, null, 1);
      view.stale = true;
    }
    this.state = state;
    button.hidden = law.parentElement.hidden = state === 'none';
    law.disabled = state !== 'free';
    button.textContent = say({held: 'head.release', joining: 'head.joining'}[state] ?? 'head.take');
    button.setAttribute('aria-pressed', String(state === 'held'));
    this.page.text.textContent = text;
    this.page.values.textContent = '';
    this.page.text.parentElement.hidden = text === '';
  }

  /** The directions of the screen in the world. */
  #axes() {
    this.page.view.camera.matrixWorld.extractBasis(right, upward, away);
    away.negate();
  }

  /** Moves the target by so many metres along the screen's axes. */
  #shift(x, y, z) {
    this.page.moved();
    this.#axes();
    this.target.addScaledVector(right, x).addScaledVector(upward, y).addScaledVector(away, z);
    this.moved = true;
  }

  /** Size of a pixel [m] at the target, so that it stays under the pointer. */
  #pixel() {
    const {view} = this.page;
    this.#axes();
    const distance = projected.copy(this.target).sub(view.camera.position).dot(away);
    return (2 * distance * Math.tan((view.camera.fov * Math.PI) / 360)) / view.height;
  }

  #near(event, reach = GRASP) {
    const {view, stage} = this.page;
    const corner = stage.getBoundingClientRect();
    const [x, y] = [event.clientX - corner.left, event.clientY - corner.top];
    const place = view.projectPoint(projected.copy(this.target), {x: 0, y: 0, seen: false});
    if (Math.hypot(place.x - x, place.y - y) < reach) return true;
    return view.handAt(x, y, reach) === this.number && this.number !== null;
  }

  /** Puts the target on the body under the pointer, a little below its surface. @returns {boolean} whether one is there that moves */
  #goToBody(event) {
    const {view, stage} = this.page;
    const corner = stage.getBoundingClientRect();
    const body = view.bodyAt(event.clientX - corner.left, event.clientY - corner.top);
    if (!body) return false;
    this.page.moved();
    this.target.copy(body.point).addScaledVector(body.direction, PRESS);
    return (this.moved = true);
  }

  #down(event) {
    if (this.state !== 'held' || event.button !== 0) return;
    if (this.pointers.size === 0 && !this.#near(event, ON_HAND) && !this.#goToBody(event) && !this.#near(event)) return;
    event.stopPropagation();
    event.preventDefault();
    this.page.view.canvas.focus();
    this.page.view.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
  }

  /** One finger moves in the plane of the screen; of two, the way between them is the depth. */
  #move(event) {
    const last = this.pointers.get(event.pointerId);
    if (!last) return;
    event.stopPropagation();
    const pixel = this.#pixel();
    const share = 1 / this.pointers.size;
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    const spread = (at) => (other ? Math.hypot(at.x - other.x, at.y - other.y) : 0);
    const next = {x: event.clientX, y: event.clientY};
    this.#shift(share * (next.x - last.x) * pixel, -share * (next.y - last.y) * pixel, (spread(next) - spread(last)) * pixel);
    this.pointers.set(event.pointerId, next);
  }

  #up(event) {
    if (this.pointers.delete(event.pointerId)) event.stopPropagation();
  }

  #wheel(event) {
    if (this.state !== 'held' || (this.pointers.size === 0 && !this.#near(event))) return;
    event.stopPropagation();
    event.preventDefault();
    this.#shift(0, 0, -WHEEL * event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE : 1));
  }

  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest?.('input, select, dialog, [role="separator"]')) return;
    const along = KEYS[event.key];
    if (this.state !== 'held' || (!along && event.key !== 'Escape')) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    if (!along) return this.release();
    const step = (event.shiftKey ? 10 : 1) * STEP;
    this.#shift(...along.map((share) => share * step));
  }

  /** The left stick moves in the plane of the screen, the triggers move away and near. */
  #sticks(elapsed, at) {
    const pad = [...(navigator.getGamepads?.() ?? [])].find((found) => found?.connected);
    if (!pad) return;
    const rest = (value) => (Math.abs(value ?? 0) > STICK_REST ? value : 0);
    const [x, y] = [rest(pad.axes[0]), rest(pad.axes[1])];
    const z = rest(pad.buttons[7]?.value) - rest(pad.buttons[6]?.value);
    if (x === 0 && y === 0 && z === 0) return;
    const way = STICK_SPEED * elapsed;
    this.#shift(x * way, -y * way, z * way);
    if (at < 0) return;
    const hand = tool.fromArray(this.page.view.picture.floats, this.page.view.picture.handAt(at) + AT.position);
    this.target.sub(hand).clampLength(0, STICK_REACH).add(hand);
  }
}
