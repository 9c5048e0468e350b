// The live page: connects, keeps the newest picture, and draws.

import {Admin} from './admin.js';
import {Connection} from './connection.js';
import {makeContext} from './context.js';
import {make} from './elements.js';
import {Foxglove} from './foxglove.js';
import {Hands} from './hands.js';
import {Labels} from './labels.js';
import {say, showLanguage} from './language.js';
import {readLink} from './link.js';
import {Plots} from './live_plots.js';
import {KIND, Picture, readGeometry} from './messages.js';
import {OwnHand} from './own_hand.js';
import {robotTexts} from './robot.js';
import {Asides, bindKeys, followTheme, makeSplit} from './panels.js';
import {PlotBar} from './plot_bar.js';
import {RecordBar} from './record_bar.js';
import {Replay} from './replay/replay.js';
import {SceneBar} from './scene_bar.js';
import {Sessions} from './sessions.js';
import {standsAlone} from './stands_alone.js';
import {Times} from './times.js';
import {Tour} from './tour.js';
import {View} from './view.js';
import {Why} from './why.js';
import * as words from './words.js';

const PLOT_PERIOD = 100;  // [ms]
const PLOT_PATIENCE = 1500;  // [ms] since the page was asked for, after which plots are made also before the first picture
const TEXT_PERIOD = 200;  // [ms]
const ON_HAND = 10;  // [px] a click so near to a hand is on it
const PICTURE_PATIENCE = 1000;  // [ms] from a scene to its first picture, after which the scene alone is drawn

const element = (id) => document.getElementById(id);
showLanguage(element('language'));
const view = makeView();
const hands = new Hands();
const plots = new Plots(element('plots'), element('plot-time'), () => hold(true));
const plotBar = new PlotBar(plots, () => ({...page, name: sessions.name(page.chosen)}), plotHands);
const why = new Why(element('sentence'), element('reasons'));
const sessions = new Sessions(document.querySelector('#sessions table'), element('columns'), choose);
const labels = new Labels(element('labels'));
const bar = new SceneBar(view, () => page);
const admin = new Admin(element('admin'), (message) => connection.send(message), (file) => replay.open([file]));
const foxglove = new Foxglove(element('foxglove'));
const times = new Times(element('times'), () => page.scene, () => ({name: sessions.name(page.chosen), session: sessions.sessions.get(page.chosen)}));
let link = readLink(location.hash);  // what of it is still to be followed
const page = {scene: link.scene, pictures: 0, firstPicture: null, sceneAt: null, unread: 0, held: false, chosen: null, connection: '', version: ''};
const replay = new Replay(() => connection.end(say('link.replayed')));
const recording = new RecordBar(() => page, (message) => connection.send(message), (file) => replay.open([file]));
let latest = new Picture();  // the newest that came
let spare = new Picture();  // the one that is read next
let arrived = false;  // whether `latest` has not been drawn yet

const connection = new Connection({
  text: takeText,
  binary: takeBinary,
  state(state, said) {
    page.connection = state;
    element('state').dataset.state = state;
    const text = element('state').querySelector('span');
    if (text.textContent !== said) text.textContent = said;
    element('retry').hidden = state !== 'waiting';
    element('token-words').textContent = said;
    const dialog = element('token');
    if (state !== 'live' && state !== 'silent') {
      own.reset();
      recording.end(say(state === 'ended' ? 'record.why.shown' : 'record.why.lost'));
    }
    if (state === 'token' && !dialog.open) dialog.showModal();
    if (state !== 'token' && dialog.open) dialog.close();
    document.body.classList.toggle('old', state !== 'live');
  },
});

const own = new OwnHand({
  view, stage: element('stage'), button: element('take'), law: element('law'), text: element('own-state'), values: element('own-values'),
  send: (message) => connection.send(message), found: choose,
  scale(factor) {
    view.depthFactor = factor;
    bar.show();
  },
  moved: () => tour.yield(),
});

const asides = new Asides();
const tour = new Tour(element('tour'), {
  own, hands, sessions: () => sessions.sessions, admin: () => admin.unlocked, send: (message) => connection.send(message), choose,
  unlock: () => asides.show(element('admin')), close: () => element('tour-open').click(),
  scale: (perNewton) => bar.fixArrows(perNewton),
});
asides.add(element('admin'), element('admin-open'), (open) => open && admin.focus());
asides.add(element('tour'), element('tour-open'), (open) => tour.show(open));

function takeText(message) {
  switch (message.type) {
    case 'hello':
      view.hands.trails.clear();
      why.hello(message);
      sessions.reasons = message.reasons ?? [];
      showScenes(message.scenes ?? []);
      admin.hello(message);
      own.hello(message);
      times.hello(message);
      page.version = message.version ?? '';
      element('version').textContent = `feltwire ${page.version}`;
      break;
    case 'scene':
      recording.watch(message);
      if (message.name !== page.scene) forget();
      page.scene = message.name;
      element('scenes').value = message.name;
      document.title = say('app.title', {scene: message.name});
      view.setScene(message);
      page.sceneAt ??= performance.now();
      admin.scene(message);
      tour.scene(message);
      bar.show();
      followLink();
      break;
    case 'sessions':
      sessions.set(message.sessions ?? []);
      view.tools.setSessions(message.sessions ?? []);
      own.find(sessions.sessions);
      break;
    case 'ticket':
      if (!recording.takeTicket(message)) foxglove.show(message);
      break;
    case 'hand':
      own.take(message);
      break;
    case 'materials':
    case 'admin':
    case 'changed':
    case 'recordings':
    case 'download':
    case 'refused':
      if (message.type === 'refused') recording.refuse();
      admin.take(message);
      break;
    case 'log':
      element('log').hidden = false;
      element('log').dataset.level = message.level ?? '';
      element('log').querySelector('span').textContent = message.text ?? '';
      break;
  }
}

function takeBinary(buffer) {
  const kind = new Uint8Array(buffer)[0];
  if (kind === KIND.geometry) {
    const geometry = readGeometry(buffer);
    if (geometry) view.addGeometry(geometry);
  } else if (kind === KIND.surfaces) {
    if (!page.held && !view.surfaces.read(buffer)) page.unread += 1;
  } else if (kind === KIND.picture) {
    if (!spare.read(buffer)) {
      page.unread += 1;
      return;
    }
    page.pictures += 1;
    if (page.held) return;
    [latest, spare] = [spare, latest];
    arrived = true;
    hands.update(latest);
  }
}

function makeView() {
  try {
    return new View(element('canvas'));
  } catch (error) {
    if (!makeContext(element('canvas'))) {
      element('state').dataset.state = 'failed';
      element('state').querySelector('span').textContent = say('app.webgl');
    }
    throw error;
  }
}

/** Another scene is watched: nothing of the last one holds. */
function forget() {
  hands.clear();
  sessions.set([]);
  choose(null);
}

function showScenes(names) {
  element('scene-choice').hidden = names.length < 2;
  element('scenes').replaceChildren(...names.map((name) => new Option(name)));
  if (page.scene && names.includes(page.scene)) {
    element('scenes').value = page.scene;
    if (names[0] !== page.scene) connection.send({watch: page.scene});  // A new connection begins with the first scene.
  }
}

/** Whether the scene of the link is watched. */
const isLinked = () => link.scene === '' || link.scene === page.scene;

/** Puts the camera where the link says. */
function followLink() {
  if (link.pose === null || !isLinked()) return;
  bar.follow(false);
  view.pose = link.pose;
  link.pose = null;
}

function chooseLinked() {
  const number = link.hand;
  link.hand = null;
  choose(number);
}

/** Another link was opened in this window. */
function takeLink() {
  link = readLink(location.hash);
  if (isLinked()) followLink();
  else connection.send({watch: link.scene});
}

/** @param {number | null} number of a hand, or null for none */
function choose(number) {
  page.chosen = number;
  view.chosen = number;
  view.stale = true;
  writeTexts();
  plots.update(plotHands());
}

/** Hands that may be plotted, the chosen one first. */
function plotHands() {
  const chosen = hands.all.get(page.chosen);
  const others = hands.numbers().map((number) => hands.all.get(number)).filter((hand) => hand !== chosen);
  return (chosen ? [chosen, ...others] : []).map(({number, history}) => ({number, name: sessions.name(number), history}));
}

function chooseNext(step) {
  const numbers = hands.numbers();
  if (numbers.length === 0) return;
  choose(numbers[(numbers.indexOf(page.chosen) + step + numbers.length) % numbers.length]);
}

function writeTexts() {
  if (page.chosen === null || (!hands.all.has(page.chosen) && !sessions.sessions.has(page.chosen))) {
    page.chosen = view.chosen = hands.numbers()[0] ?? null;
  }
  const hand = hands.all.get(page.chosen);
  const name = page.chosen === null ? say('hand.none') : sessions.name(page.chosen);
  const title = page.chosen === null || !sessions.sessions.get(page.chosen)?.client ? name : say('hand.named', {name, number: page.chosen});
  for (const id of ['chosen', 'why-name']) {
    if (element(id).title === title) continue;
    element(id).textContent = words.middle(title, 40);
    element(id).title = title;
  }
  why.show(hand, page.pictures > 0, sessions.sessions.get(page.chosen));
  sessions.show(hands.all, page.chosen);
  admin.choose(sessions.sessions.get(page.chosen));
  labels.write(hands.all, (number) => sessions.name(number), page.chosen);
  own.write(hands.all.get(own.number));
  writeRobots();
  element('empty').hidden = hands.all.size > 0 || page.pictures === 0;
  element('empty').textContent = say('scene.empty');
}

/** Holds the picture and the plots, or lets both go on. */
function hold(held) {
  if (held === page.held) return;
  page.held = held;
  if (!held) plots.follow();
  element('hold').setAttribute('aria-pressed', String(page.held));
  element('hold').textContent = say(page.held ? 'head.hold.on' : 'head.hold');
  writeTexts();  // Of the picture that is held: else names become longer later, and lie on each other.
  view.stale = true;
}

/** From its top, wherever it was left. */
function openHelp() {
  if (!element('help').open) element('help').showModal();
  element('help').scrollTop = 0;
}

function writeRobots() {
  const texts = robotTexts(view.picture, view.seats);
  const list = element('robots');
  while (list.children.length < texts.length) list.append(make('p', {}, make('b'), ' ', make('span')));
  [...list.children].forEach((line, i) => {
    line.hidden = i >= texts.length;
    line.querySelector('b').textContent = texts[i]?.state ?? '';
    line.querySelector('span').textContent = texts[i]?.values ?? '';
  });
}

let drawn = false;  // the first picture
let plotted = 0;
let written = 0;

function step(now) {
  if (replay.active) return;
  if (drawn) page.firstPicture ??= performance.now();  // [ms] since the page was asked for: the next frame begins, so it is on the screen
  requestAnimationFrame(step);
  if (arrived) {
    arrived = false;
    view.show(latest);
    if (link.hand !== null && isLinked() && hands.all.has(link.hand)) chooseLinked();
  }
  if (hands.changed || now - written > TEXT_PERIOD) {
    hands.changed = false;
    written = now;
    writeTexts();
  }
  tour.run(now);
  own.step(now);
  // With software rendering, frames of an empty view would delay the first picture.
  if ((page.pictures > 0 || (page.sceneAt !== null && now - page.sceneAt > PICTURE_PATIENCE)) && view.render()) {
    labels.move(view);
    bar.step();
    drawn ||= page.pictures > 0;
  }
  if (page.firstPicture !== null || now > PLOT_PATIENCE) plots.begin();
  if (now - plotted > PLOT_PERIOD && !page.held) {
    plotted = now;
    plots.update(plotHands());
  }
}

let pressed = null;
element('canvas').addEventListener('pointermove', (event) => (element('canvas').title = labels.cutName(event.clientX, event.clientY)));
element('canvas').addEventListener('pointerdown', (event) => (pressed = {x: event.clientX, y: event.clientY}));
element('canvas').addEventListener('pointerup', (event) => {
  if (!pressed || Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) > 5) return;  // That was a turn of the camera.
  const corner = element('canvas').getBoundingClientRect();
  const [x, y] = [event.clientX - corner.left, event.clientY - corner.top];
  // The label of one hand may lie over another hand: a click on a hand chooses that hand.
  const found = view.handAt(x, y, ON_HAND) ?? labels.at(event.clientX, event.clientY) ?? view.handAt(x, y);
  if (found !== null) choose(found);
});
element('scenes').onchange = (event) => connection.send({watch: event.target.value});
addEventListener('hashchange', takeLink);
element('retry').onclick = () => connection.connect();
element('hold').onclick = () => hold(!page.held);
element('help-open').onclick = openHelp;
element('foxglove-open').onclick = () => {
  element('help').close();
  connection.send({ticket: page.scene});
};
element('previous').onclick = () => chooseNext(-1);
element('next').onclick = () => chooseNext(1);
element('times-open').onclick = () => times.open();
element('log').querySelector('button').onclick = () => (element('log').hidden = true);
element('token').addEventListener('cancel', (event) => event.preventDefault());
element('token').querySelector('form').onsubmit = (event) => {
  event.preventDefault();
  connection.useToken(element('token-text').value.trim());
  element('token-text').value = '';
};

bindKeys(element('keys'), [
  {keys: ['n', 'p'], shown: 'n, p', text: say('keys.hands'), act: (key) => chooseNext(key === 'n' ? 1 : -1)},
  {keys: [...'1234567890'], shown: '1 … 9, 0', text: say('keys.numbers'), act: (key) => choose(hands.numbers()[(Number(key) + 9) % 10] ?? page.chosen)},
  {keys: ['ArrowLeft', 'ArrowRight'], shown: '← →', text: say('keys.turn'), act: (key) => view.turn(key === 'ArrowLeft' ? -0.1 : 0.1, 0)},
  {keys: ['ArrowUp', 'ArrowDown'], shown: '↑ ↓', text: say('keys.raise'), act: (key) => view.turn(0, key === 'ArrowUp' ? -0.1 : 0.1)},
  {keys: ['+', '=', '-'], shown: '+ −', text: say('keys.zoom'), act: (key) => view.zoom(key === '-' ? 1 / 1.2 : 1.2)},
  ...bar.bindings(),
  {keys: ['g'], text: say('keys.take'), act: () => own.toggle()},
  {keys: [' '], shown: say('keys.space'), text: say('keys.hold'), act: () => hold(!page.held)},
  ...plotBar.bindings(),
  ...recording.bindings(),
  {keys: ['o'], text: say('keys.open'), act: () => element('recording-files').click()},
  {keys: ['w'], text: say('tour.key'), act: () => element('tour-open').click()},
  {keys: ['h'], text: say('keys.times'), act: () => times.open()},
  {keys: ['l'], text: say('keys.theme'), act: () => element('theme').click()},
  {keys: ['?'], text: say('keys.help'), act: openHelp},
], () => !replay.active);
makeSplit(element('split-x'), '--side-width', {axis: 'x', least: 220, most: () => innerWidth - 320});
makeSplit(element('split-y'), '--table-height', {axis: 'y', least: 60, most: () => innerHeight - 320});
followTheme(element('theme'), (colors) => {
  view.paint(colors);
  plots.paint(colors);
  replay.paint(colors);
  own.paint(colors);
  tour.paint(colors);
});
bar.show();
if (standsAlone()) replay.start();
else connection.connect();
requestAnimationFrame(step);

/** What tests and a curious user read in the console: a copy, so that nothing can be changed by it. */
window.feltwire = () => ({
  ...page, frames: view.frames, hands: hands.numbers(), longestArrow: view.hands.longest, perNewton: view.perNewton,
  bodies: view.objects?.bodies.size ?? 0, bodyPlaces: view.bodyPlaces(), time: view.picture?.time ?? null, plotted: {points: plots.points, range: plots.window.range(plots.end), end: plots.end, tops: plots.panes.map(({plot}) => plot?.scales.y.max), gaps: [...plots.panes[0].plot?.data[1] ?? []].filter(Number.isNaN).length, last: plots.panes.map((pane) => pane.plot?.data.slice(1).map((column) => column.at?.(-1)))},
  places: view.places(), robots: view.robots.look(), surfaces: view.surfaces.mesh.visible ? view.surfaces.count : 0,
  strongest: view.strongest, contacts: view.hands.contacts, edges: view.objects?.edgeCounts() ?? [], viewHeight: view.pixel * view.height, axes: [view.origin, ...view.axisEnds.map(({point}) => point)].map((point) => view.projectPoint(point, {x: 0, y: 0, seen: false})), pose: view.pose,
  guides: view.objects?.guides.length ?? 0, trails: view.hands.trails.shown ? view.hands.trails.lengths() : [],
  solids: view.objects?.sizes() ?? [],
  toolBalls: view.tools.balls.count, toolPoints: view.tools.dots.count, replay: replay.state(), recorded: recording.seconds, own: own.look(hands.all.get(own.number)), tour: tour.look(),
});
