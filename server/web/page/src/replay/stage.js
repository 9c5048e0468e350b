// A recording on the page: the hands in 3D, plots, and why a hand felt what it felt.

import {Labels} from '../labels.js';
import {say} from '../language.js';
import {AT, BODY_AT, HAND_WORDS, length3, Picture} from '../messages.js';
import {fileName, save, saveCanvas} from '../save.js';
import {View} from '../view.js';
import {sentence} from '../why.js';
import * as words from '../words.js';
import {Box} from './box.js';
import {bodiesAt, cubeGeometry} from './bodies.js';
import {Overview} from './overview.js';
import {ReplayPlots} from './plots.js';
import {OBSERVER, REASONS} from './reasons.js';
import {rowAt} from './recording.js';
import {placesAt} from './scene_of_file.js';
import {ACCOUNT, askedForce, FRESH, ROW} from './tables.js';

const OWN = 0;  // number of the hand that recorded; those of /scene/picture begin at 1
const TRAIL_TIME = 3;  // [s]
const TRAIL_STEP = 1 / 60;  // [s]
const LEAST_BOX = 0.04;  // [m]

export class Stage {
  /**
   * @param {import('./recording.js').Recording} recording
   * @param {{seek: (time: number) => void, zoom: (factor: number) => void, close: () => void, news: () => void}} on seek: in this recording's time; zoom: of the plots
   */
  constructor(recording, on) {
    this.recording = recording;
    this.on = on;
    this.overview = new Overview(recording);
    this.root = document.getElementById('replay-stage').content.firstElementChild.cloneNode(true);
    this.part = (name) => this.root.querySelector(`[data-part="${name}"]`);
    this.view = null;
    this.labels = null;
    this.picture = new Picture();
    this.time = 0;
    this.shown = [];  // numbers of the hands in the picture
    this.chosen = OWN;
    this.bodies = new Map();  // name -> index
    this.boxed = '';
    this.whole = false;
    this.perNewton = 0.01;  // [m] that fits this recording
    this.part('name').textContent = recording.name;
    this.part('name').title = Object.entries(recording.about).map(([key, value]) => `${key}: ${value}`).join('\n');
    this.part('about').textContent = aboutText(recording);
    this.part('close').onclick = on.close;
    this.part('csv').onclick = () => save(new Blob([this.plots.csv()], {type: 'text/csv'}), fileName('csv', recording.name));
    this.part('png').onclick = () => saveCanvas(this.plots.image(`${recording.name}, ${this.name(this.chosen)}`), fileName('png', recording.name));
    this.part('next').onclick = () => this.chooseNext(1);
    this.part('marks').onchange = ({target}) => {
      on.seek(this.overview.marks[target.selectedIndex - 1].time);
      target.selectedIndex = 0;
    };
  }

  /** After the root is in the page. @param {object} colors of the theme */
  begin(colors) {
    this.view = new View(this.part('canvas'));
    this.view.depthFactor = 1;
    this.box = new Box();
    this.view.scene.add(this.box.group);
    this.labels = new Labels(this.part('labels'));
    this.plots = new ReplayPlots(this.part('plots'), this.part('plot-time'), this.recording, this.on);
    this.paint(colors);
    this.overview.run(() => {
      this.#fit();
      this.#listMarks();
      this.on.news();
    });
  }

  end() {
    this.overview.stop();
    this.plots.end();
    this.view.renderer.dispose();
    this.view.renderer.forceContextLoss();
    this.root.remove();
  }

  paint(colors) {
    this.view.paint(colors);
    this.box.paint(colors);
    this.plots.paint(colors);
  }

  /** Every number of a hand that was seen in the recording so far, ascending. */
  hands() {
    return [...(this.overview.ownHand ? [OWN] : []), ...this.overview.hands].sort((a, b) => a - b);
  }

  /** Values of the first hand of the picture, for tests. */
  firstHand() {
    if (this.shown.length === 0) return null;
    const [{floats}, at] = [this.picture, this.picture.handAt(0)];
    const vector = (from) => [...floats.subarray(at + from, at + from + 3)];
    return {position: vector(AT.position), elastic: vector(AT.elastic), friction: vector(AT.friction), held: vector(AT.rendered)};
  }

  chooseNext(step) {
    const hands = this.hands();
    if (hands.length > 0) this.chosen = hands[(hands.indexOf(this.chosen) + step + hands.length) % hands.length];
    this.show(this.time);
  }

  name(number) {
    return number === OWN ? this.recording.about.client ?? say('replay.hand') : say('hand.number', {number});
  }

  /** Shows a moment. What is not read yet comes later, by `changed` of the recording. @param {number} time [s] of this recording */
  show(time) {
    this.time = time;
    const {segments, whole} = this.recording.segments(time - TRAIL_TIME, time);
    this.whole = whole;
    const account = rowAt(segments, (segment) => segment.accounts, time);
    const hands = this.#handsAt(segments, time, account);
    if (!hands.has(this.chosen) && hands.size > 0 && !this.hands().includes(this.chosen)) this.chosen = hands.keys().next().value;
    const places = this.recording.scene ? placesAt(segments, time) : this.#placeBodies(bodiesAt(segments, time));
    this.picture.read(pictureOf(hands, places, time, this.recording.scene?.version ?? 1));
    this.shown = [...hands.keys()];
    this.view.chosen = this.chosen;
    this.view.show(this.picture);
    for (const number of hands.keys()) this.view.hands.trails.set(number, this.#trail(segments, number, time));
    this.#write(hands, account, time);
    this.plots.show(time, this.chosen === OWN ? null : this.chosen);
  }

  /** Draws, if anything changed. */
  render() {
    if (this.view.render()) this.labels.move(this.view);
  }

  #handsAt(segments, time, account) {
    const hands = new Map();
    const add = (number, tableOf) => {
      const found = rowAt(segments, tableOf, time);
      if (found && found.time >= time - FRESH) hands.set(number, found.table.rows.subarray(found.row, found.row + ROW.size));
    };
    if (account?.table.rows[account.row + ACCOUNT.reason] !== OBSERVER) add(OWN, (segment) => segment.own);
    for (const number of new Set(segments.flatMap((segment) => [...segment.hands.keys()]))) add(number, (segment) => segment.hands.get(number));
    return hands;
  }

  /** Places of a hand in the last seconds, the oldest first. */
  #trail(segments, number, time) {
    const places = [];
    const tableOf = (segment) => (number === OWN ? segment.own : segment.hands.get(number));
    for (let at = time - TRAIL_TIME; at <= time; at += TRAIL_STEP) {
      const found = rowAt(segments, tableOf, at);
      if (found && found.time >= at - FRESH) places.push(...found.table.rows.subarray(found.row, found.row + 3));
    }
    return places;
  }

  /** New bodies get an index and a shape. @returns {Map<number, Float32Array>} where they are, by their index */
  #placeBodies(bodies) {
    let isNew = false;
    for (const name of bodies.keys()) {
      if (this.bodies.has(name)) continue;
      this.bodies.set(name, {index: this.bodies.size, size: bodies.get(name).size});
      isNew = true;
    }
    if (isNew || !this.view.objects) this.#setScene();
    return new Map([...bodies].map(([name, {pose}]) => [this.bodies.get(name).index, pose]));
  }

  #listMarks() {
    const {marks} = this.overview;
    const list = this.part('marks');
    list.hidden = marks.length === 0;
    if (list.length === marks.length + 1) return;
    list.replaceChildren(new Option(say('replay.marks', {count: marks.length})), ...marks.map(({time, text}) => new Option(`${words.clock(time)} ${text}`)));
  }

  /** The box is where hands were, so far as is known. */
  #fit() {
    const {low, high} = this.overview;
    if (this.recording.scene) return this.#fitScene();
    if (low[0] > high[0]) return;
    this.box.follow(this.overview.way);
    this.view.stale = true;
    const box = `${low} ${high}`;
    if (box === this.boxed) return;
    this.boxed = box;
    this.#setScene();
    this.view.lookAtAll();
  }

  /** The scene of the file, with as many of its objects as have been read. */
  #fitScene() {
    const {scene, triangles} = this.recording;
    const boxed = `${triangles.length} objects`;
    if (this.boxed !== boxed) {
      this.boxed = boxed;
      this.box.group.visible = false;
      this.view.setScene(scene);
      for (const geometry of triangles) this.view.addGeometry(geometry);
    }
    this.#fitArrows();
  }

  #fitArrows() {
    const longest = this.recording.scene ? 0.3 : 0.9;  // share of what is seen: else that is where hands were
    this.perNewton = words.roundDown((longest * this.view.frame.size) / Math.max(this.overview.most, 1));
    this.on.news();
  }

  #setScene() {
    const {low, high} = this.overview;
    const known = low[0] <= high[0];
    const grow = (axis) => (known ? Math.max(0.15 * (high[axis] - low[axis]), (LEAST_BOX - (high[axis] - low[axis])) / 2) : LEAST_BOX);
    const from = [0, 1, 2].map((axis) => (known ? low[axis] : 0) - grow(axis));
    const to = [0, 1, 2].map((axis) => (known ? high[axis] : 0) + grow(axis));
    const objects = [...this.bodies].map(([name, {index}]) => ({index, name, moves: true}));
    this.view.setScene({name: this.recording.name, version: 1, objects, guides: [], box: [from, to]});
    for (const {index, size} of this.bodies.values()) this.view.addGeometry(cubeGeometry(index, size));
    this.box.fit(from, to, this.view.spacing);
    this.#fitArrows();
  }

  /** @param {number} perNewton [m] of all arrows */
  scale(perNewton) {
    this.view.perNewton = perNewton;
    const text = say('replay.scale', {arrow: words.distance(perNewton), grid: words.distance(this.view.spacing)});
    if (this.part('scale').textContent !== text) this.part('scale').textContent = text;
  }

  #write(hands, account, time) {
    const put = (name, text) => {
      if (this.part(name).textContent !== text) this.part(name).textContent = text;
    };
    const shown = new Map([...hands].map(([number, row]) => [number, {floats: handWords(number, row)}]));
    this.labels.write(shown, (number) => this.name(number), this.chosen);
    const row = hands.get(this.chosen);
    const count = this.hands().length;
    put('chosen', row || count > 0 ? (count > 1 ? say('replay.one.of', {name: this.name(this.chosen), count}) : this.name(this.chosen)) : '');
    this.part('next').hidden = count < 2;
    put('sentence', row ? handSentence(row) : this.#emptySentence(time));
    const own = this.chosen === OWN && row && account && account.time >= time - FRESH;
    put('reason', own ? reasonSentence(account.table.rows.subarray(account.row, account.row + ACCOUNT.size)) : '');
    put('trouble', this.recording.troubles.join('\n'));
    this.part('trouble').hidden = this.recording.troubles.length === 0;
  }

  #emptySentence(time) {
    if (!this.whole) return say('replay.reading');
    if (time < 0 || time > this.recording.duration) return say('replay.outside');
    return say('replay.nobody');
  }
}

/** @param {Float32Array} row of a hand */
function handSentence(row) {
  const held = length3(row, ROW.held);
  if (Number.isNaN(row[ROW.elastic])) return held > 0 ? say('replay.given', {force: words.force(held)}) : say('replay.given.none');
  return sentence({commanded: askedForce(row, 0), rendered: held, floats: handWords(0, row)});
}

/** @param {Float32Array} account */
function reasonSentence(account) {
  const cut = account[ACCOUNT.cut];
  const number = account[ACCOUNT.reason];
  const name = REASONS[number];
  const parts = [name ? say('replay.reason', {name, text: say(`recorded.${name}`)}) : say('replay.reason.unknown', {number})];
  if (cut > 0.005) parts.push(say('replay.cut', {share: words.percent(cut)}));
  return parts.join(' ');
}

function aboutText({about, duration}) {
  const {client, device, scene, version} = about;
  const text = [client && device ? `${client}, ${device}` : '', scene ? say('replay.about.scene', {scene}) : '', version ? `feltwire ${version}` : ''];
  return [...text.filter(Boolean), words.duration(duration)].join(' · ');
}

/** A hand's record as the live page has it. What a recording does not tell is not a number. */
function handWords(number, row) {
  const floats = new Float32Array(HAND_WORDS).fill(NaN);
  new Uint32Array(floats.buffer)[AT.number] = number;
  new Uint32Array(floats.buffer)[AT.reasons] = 0;
  const vector = (to, from) => floats.set(Number.isNaN(row[from]) ? [0, 0, 0] : row.subarray(from, from + 3), to);
  vector(AT.position, ROW.position);
  vector(AT.proxy, Number.isNaN(row[ROW.proxy]) ? ROW.position : ROW.proxy);
  floats[AT.depth] = row[ROW.depth];
  floats.set(row.subarray(ROW.orientation, ROW.orientation + 4), AT.orientation);
  vector(AT.elastic, ROW.elastic);
  vector(AT.friction, ROW.friction);
  vector(AT.rendered, ROW.held);
  return floats;
}

/** A picture as the live page has it. @param {Map<number, Float32Array>} places of bodies, by their index @returns {ArrayBuffer} */
function pictureOf(hands, places, time, version) {
  const head = 6;
  const buffer = new ArrayBuffer(4 * (head + HAND_WORDS * hands.size + 8 * places.size));
  const [words32, floats] = [new Uint32Array(buffer), new Float32Array(buffer)];
  words32.set([2, hands.size, places.size, version]);
  new DataView(buffer).setFloat64(16, time, true);
  let at = head;
  for (const [number, row] of hands) {
    words32.set(new Uint32Array(handWords(number, row).buffer), at);
    at += HAND_WORDS;
  }
  for (const [index, pose] of places) {
    words32[at + BODY_AT.index] = index;
    floats.set(pose.subarray(0, 3), at + BODY_AT.position);
    floats.set(pose.subarray(3), at + BODY_AT.orientation);
    at += 8;
  }
  return buffer;
}
