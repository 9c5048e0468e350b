// Shows recordings of this machine: one, or two side by side, with a common time bar. Nothing is sent, and nothing is asked of a server.

import {say} from '../language.js';
import {bindKeys} from '../panels.js';
import {clock} from '../words.js';
import {CLASSES} from './reasons.js';
import {Recording} from './recording.js';
import {Stage} from './stage.js';
import {TimeBar} from './time_bar.js';

const MOST = 2;
const SECONDS = {least: 0.05, most: 120};  // of the plots
const SPEEDS = [0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10];
const element = (id) => document.getElementById(id);

export class Replay {
  /** @param {() => void} begin called once, before the first recording is shown: the live page ends */
  constructor(begin) {
    this.begin = begin;
    this.active = false;
    this.stages = [];  // {stage, offset}: the recording's time 0 is `offset` on the bar
    this.time = 0;
    this.playing = false;
    this.speed = 1;
    this.seconds = 5;  // of the plots
    this.colors = null;
    this.stale = true;
    this.last = 0;
    document.body.dataset.drop = say('replay.drop');
    this.bar = new TimeBar(element('replay-bar'), (time) => this.seek(time));
    element('open-recording').onclick = () => element('recording-files').click();
    element('replay-choose').onclick = () => element('recording-files').click();
    element('recording-files').onchange = async (event) => {
      const files = [...event.target.files];
      event.target.value = '';  // So that the same file can be chosen again.
      await this.open(files);
    };
    element('replay-play').onclick = () => this.play(!this.playing);
    element('replay-speed').replaceChildren(...SPEEDS.map((speed) => new Option(`${speed} ×`, speed, speed === 1, speed === 1)));
    element('replay-speed').onchange = (event) => (this.speed = Number(event.target.value));
    element('replay-window').onchange = ({target}) => this.#showSeconds(Number(target.value));
    element('replay-offset').oninput = (event) => this.setOffset(Number(event.target.value) || 0);
    element('replay-clock').onclick = () => this.#byClock();
    element('live-page').hidden = location.protocol === 'file:';
    element('live-page').onclick = () => location.assign('./');
    element('replay-classes').append(...CLASSES.map(({name, color}) => legendItem(say(`class.${name}`), say(`class.${name}.hint`), color)));
    addEventListener('dragover', (event) => this.#drag(event, true));
    addEventListener('dragleave', (event) => event.relatedTarget === null && this.#drag(event, false));
    addEventListener('drop', (event) => {
      this.#drag(event, false);
      this.open([...event.dataTransfer.files]);
    });
    addEventListener('resize', () => this.#news());
    this.#bindKeys();
  }

  /** The page is one of recordings from now on. */
  start() {
    if (this.active) return;
    this.active = true;
    this.begin();
    document.body.classList.add('replaying');
    element('replay').hidden = false;
    document.title = say('replay.title');
    requestAnimationFrame((now) => this.#step(now));
  }

  /** @param {File[]} files a second one stands beside the first; a third takes the place of the second */
  async open(files) {
    for (const file of files.slice(0, MOST)) {
      try {
        const recording = await Recording.open(file, () => this.#news());
        this.start();
        this.#add(recording);
      } catch (error) {
        this.start();
        complain(error.message);
      }
    }
  }

  #add(recording) {
    if (this.stages.length === MOST) this.#close(this.stages[MOST - 1]);
    element('log').hidden = true;
    const entry = {stage: null, offset: 0};
    entry.stage = new Stage(recording, {
      seek: (time) => this.seek(time + entry.offset), zoom: (factor) => this.zoom(factor), close: () => this.#close(entry), news: () => this.#news(),
    });
    this.stages.push(entry);
    element('replay-stages').append(entry.stage.root);
    entry.stage.begin(this.colors);
    if (this.stages.length === 1) this.time = 0;
    this.#arrange();
    if (this.stages.length === 1) this.#begin(entry);
  }

  /** Goes to the first hand, unless the user has gone elsewhere by then. */
  async #begin({stage, offset}) {
    const time = await stage.recording.begin();
    if (this.time === 0 && !this.playing && this.stages[0]?.stage === stage) this.seek(time + offset);
  }

  /** @param {1 | -1} step to the next mark of any recording, or the one before */
  #goToMark(step) {
    const times = this.stages.flatMap(({stage, offset}) => stage.overview.marks.map(({time}) => time + offset)).filter((time) => step * (time - this.time) > 1e-6);
    if (times.length > 0) this.seek(step > 0 ? Math.min(...times) : Math.max(...times));
  }

  #close(entry) {
    this.stages.splice(this.stages.indexOf(entry), 1);
    entry.stage.end();
    if (this.stages.length > 0) this.stages[0].offset = 0;
    this.#arrange();
  }

  #arrange() {
    const count = this.stages.length;
    element('replay').dataset.count = count;
    element('replay-empty').hidden = count > 0;
    element('replay-controls').hidden = count === 0;
    for (const id of ['replay-offset-label', 'replay-clock']) element(id).hidden = count < 2;
    element('open-recording').textContent = say(count === 1 ? 'head.open.second' : 'head.open');
    document.title = count > 0 ? say('app.title', {scene: this.stages.map(({stage}) => stage.recording.name).join(', ')}) : say('replay.title');
    if (count === 0) this.play(false);
    if (count > 1) element('replay-offset').value = +this.stages[1].offset.toFixed(3);
    this.seek(this.time);
  }

  /** Moves the second recording along the bar. @param {number} offset [s] */
  setOffset(offset) {
    if (this.stages.length < 2) return;
    this.stages[1].offset = offset;
    this.seek(this.time);
  }

  /** Puts the second where it was recorded, by the clocks of the machines. */
  #byClock() {
    const [first, second] = this.stages.map(({stage}) => stage.recording.start);
    const offset = Number(second - first) / 1e9;
    element('replay-offset').value = +offset.toFixed(3);
    this.setOffset(offset);
  }

  get from() {
    return Math.min(...this.stages.map(({offset}) => offset), 0);
  }

  get to() {
    return Math.max(...this.stages.map(({stage, offset}) => offset + stage.recording.duration), this.from + 1e-3);
  }

  /** Plots show more or less time about the moment. @param {number} factor above 1: less */
  zoom(factor) {
    this.#showSeconds(Math.min(Math.max(this.seconds / factor, SECONDS.least), SECONDS.most));
  }

  #showSeconds(seconds) {
    this.seconds = seconds;
    const list = element('replay-window');
    list.options[0].textContent = `${+seconds.toPrecision(2)} s`;
    list.value = seconds;
    if (list.selectedIndex < 0) list.selectedIndex = 0;
    this.#news();
  }

  /** @param {number} time [s] on the bar */
  seek(time) {
    this.time = Math.min(Math.max(time, this.from), this.to);
    this.#news();
  }

  /** @param {boolean} playing */
  play(playing) {
    if (playing && this.time >= this.to) this.time = this.from;
    this.playing = playing && this.stages.length > 0;
    element('replay-play').setAttribute('aria-pressed', String(this.playing));
    element('replay-play').textContent = say(this.playing ? 'replay.pause' : 'replay.play');
    this.#news();
  }

  /** @param {object} colors of the theme */
  paint(colors) {
    this.colors = this.bar.colors = colors;
    for (const {stage} of this.stages) stage.paint(colors);
    this.#news();
  }

  /** What tests read, as window.feltwire().replay. */
  state() {
    const stages = this.stages.map(({stage, offset}) => ({
      name: stage.recording.name, offset, duration: stage.recording.duration, hands: stage.hands(), shown: stage.shown, whole: stage.whole,
      read: stage.overview.done === stage.recording.chunks.length, first: stage.firstHand(), troubles: stage.recording.troubles, longestArrow: stage.view.hands.longest,
      points: stage.plots.points, range: stage.plots.range, kept: stage.recording.kept, marks: stage.overview.marks, frames: stage.view.frames, bodies: stage.recording.scene ? stage.view.objects?.bodies.size ?? 0 : stage.bodies.size,
      bodyPlaces: stage.view.objects?.places() ?? [],
      solids: stage.view.objects?.sizes().length ?? 0,
    }));
    const drawn = !this.stale && this.stages.every(({stage}) => stage.whole);  // What is drawn is the present time, with all that is recorded of it.
    return {active: this.active, playing: this.playing, time: this.time, from: this.from, to: this.to, drawn, stages};
  }

  #news() {
    this.stale = true;
  }

  #step(now) {
    requestAnimationFrame((next) => this.#step(next));
    const elapsed = Math.min((now - this.last) / 1000, 0.25);
    this.last = now;
    if (this.playing && this.stages.every(({stage}) => stage.whole)) this.#advance(elapsed * this.speed);
    if (this.stale) this.#show();
    for (const {stage} of this.stages) stage.render();
  }

  #advance(elapsed) {
    this.time += elapsed;
    this.stale = true;
    if (this.time < this.to) return;
    if (element('replay-loop').checked) {
      this.time = this.from;
    } else {
      this.time = this.to;
      this.play(false);
    }
  }

  #show() {
    this.stale = false;
    [this.bar.from, this.bar.to] = [this.from, this.to];
    const said = `${clock(this.time)} / ${clock(this.to)}`;
    element('replay-time').textContent = said;
    const perNewton = Math.min(...this.stages.map(({stage}) => stage.perNewton));  // One scale, so that recordings compare.
    for (const {stage, offset} of this.stages) {
      stage.scale(perNewton);
      stage.plots.seconds = this.seconds;
      stage.show(this.time - offset);
    }
    this.bar.show(this.stages.map(({stage, offset}) => ({overview: stage.overview, offset})), this.time, said);
  }

  #drag(event, over) {
    event.preventDefault();
    document.body.classList.toggle('dragging', over);
  }

  #bindKeys() {
    const views = (act) => this.stages.forEach(({stage}) => act(stage.view));
    const turn = {ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1]};
    const chooseSpeed = (step) => {
      const list = element('replay-speed');
      list.selectedIndex = Math.min(Math.max(list.selectedIndex + step, 0), SPEEDS.length - 1);
      this.speed = Number(list.value);
    };
    bindKeys(element('replay-keys'), [
      {keys: [' '], shown: say('keys.space'), text: say('keys.play'), act: () => this.play(!this.playing)},
      {keys: ['ArrowLeft', 'ArrowRight'], shown: '← →', text: say('keys.second'), act: (key, event) => {
        if (event.shiftKey) views((view) => view.turn(...turn[key]));
        else this.seek(this.time + (key === 'ArrowLeft' ? -1 : 1));
      }},
      {keys: ['ArrowUp', 'ArrowDown'], shown: '↑ ↓', text: say('keys.hundredth'), act: (key, event) => {
        if (event.shiftKey) views((view) => view.turn(...turn[key]));
        else this.seek(this.time + (key === 'ArrowUp' ? 0.01 : -0.01));
      }},
      {keys: ['PageUp', 'PageDown'], shown: say('keys.pages'), text: say('keys.ten'), act: (key) => this.seek(this.time + (key === 'PageUp' ? -10 : 10))},
      {keys: ['Home', 'End'], shown: say('keys.ends'), text: say('keys.begin'), act: (key) => this.seek(key === 'Home' ? this.from : this.to)},
      {keys: [',', '.'], shown: ', .', text: say('keys.marks'), act: (key) => this.#goToMark(key === '.' ? 1 : -1)},
      {keys: ['[', ']'], shown: '[ ]', text: say('keys.speed'), act: (key) => chooseSpeed(key === '[' ? -1 : 1)},
      {keys: ['r'], text: say('keys.repeat'), act: () => element('replay-loop').click()},
      {keys: ['n', 'p'], shown: 'n, p', text: say('keys.hands'), act: (key) => this.stages.forEach(({stage}) => stage.chooseNext(key === 'n' ? 1 : -1))},
      {keys: ['+', '=', '-'], shown: '+ −', text: say('keys.zoom'), act: (key) => views((view) => view.zoom(key === '-' ? 1 / 1.2 : 1.2))},
      {keys: ['f'], text: say('keys.places'), act: () => views((view) => view.lookAtAll())},
      {keys: ['x', 'y', 'z'], shown: 'x, y, z', text: say('keys.axis'), act: (key) => views((view) => view.lookAlong(key))},
      {keys: ['o'], text: say('keys.open'), act: () => element('recording-files').click()},
      {keys: ['l'], text: say('keys.theme'), act: () => element('theme').click()},
      {keys: ['?'], text: say('keys.help'), act: () => element('help').showModal()},
    ], () => this.active);
  }
}

function legendItem(name, text, color) {
  const [item, mark] = ['span', 'i'].map((tag) => document.createElement(tag));
  item.title = text;
  mark.style.background = `var(--${color})`;
  item.append(mark, name);
  return item;
}

function complain(text) {
  element('log').hidden = false;
  element('log').dataset.level = 'error';
  element('log').querySelector('span').textContent = text;
}
