// A viewer's own hand on the page of a real server. Every wait is for a condition.
// FELTWIRE_PROGRAMS: the folder of feltwire-server. FELTWIRE_TEST_SCENE: a scene with a floor at z = 0.

import assert from 'node:assert/strict';
import {execFileSync, spawn} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {createInterface} from 'node:readline';
import {after, before, beforeEach, afterEach, test} from 'node:test';
import {chromium} from 'playwright-core';
import {faults, overflowing} from './judge.mjs';

const PATIENCE = 60_000;  // [ms] for a machine that draws in software and has more to do
const STIFFNESS = 600;  // [N/m] of the floor of scenes/plane.json
const server = join(process.env.FELTWIRE_PROGRAMS, 'feltwire-server');
let state;
let served;
let address;
let browser;
let page;
let complaints;

/** @param {string[]} more options @returns {Promise<void>} once the page is served */
const serve = (...more) => serveScene(process.env.FELTWIRE_TEST_SCENE, ...more);

/** @param {string} scene file @param {string[]} more options @returns {Promise<void>} once the page is served */
async function serveScene(scene, ...more) {
  const options = ['--scene', scene, '--port', '0', '--web', '0', '--state', state, ...more];
  served = spawn(server, options, {stdio: ['ignore', 'pipe', 'inherit']});
  for await (const line of createInterface({input: served.stdout})) {
    address = /^live page: (\S+)/.exec(line)?.[1];
    if (address) return;
  }
  throw new Error('the server ended');
}

async function stopServing() {
  const ended = new Promise((resolve) => served.once('exit', resolve));
  served.kill();
  await ended;
}

/** @param {string} role @returns {string} a new token of the server */
function token(role) {
  const words = ['token', 'add', '--client', role, '--role', role, '--scene', 'plane', '--expires', '1h', '--state', state];
  return /fw_\S+/.exec(execFileSync(server, words, {encoding: 'utf8'}))[0];
}

before(async () => {
  browser = await chromium.launch({executablePath: process.env.FELTWIRE_CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox']});
});
after(() => browser.close());

beforeEach(() => {
  state = mkdtempSync(join(tmpdir(), 'feltwire-hand-'));
  complaints = [];
});
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
  await stopServing();
  rmSync(state, {recursive: true, force: true});
  assert.deepEqual(complaints, []);
});

/** Half of the pixels each way: they are drawn in software, and a page that is late lets its hand go. */
async function open(text, script, deviceScaleFactor = 0.5) {
  const context = await browser.newContext({viewport: {width: 700, height: 520}, deviceScaleFactor});
  const made = await context.newPage();
  made.setDefaultTimeout(PATIENCE);
  made.on('pageerror', (error) => complaints.push(error.stack));
  made.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
  if (script) await made.addInitScript(script);
  await made.goto(`${address}#token=${text}`);
  await made.waitForFunction(() => window.feltwire?.().connection === 'live');
  return made;
}

const until = (condition, argument) => page.waitForFunction(condition, argument);
const own = () => page.evaluate(() => window.feltwire().own);

/** Takes a hand and waits until it is seen. */
async function take() {
  await page.getByRole('button', {name: 'Take a hand'}).click();
  await until(() => window.feltwire().own.number !== null && window.feltwire().own.position);
}

/** Where the target is on the page. */
const place = () => page.evaluate(() => {
  const {x, y} = window.feltwire().places.find(({number}) => number === window.feltwire().own.number);
  const {left, top} = document.querySelector('#canvas').getBoundingClientRect();
  return {x: x + left, y: y + top};
});

test('a drag presses the hand on the floor, which it feels', async () => {
  await serve();
  // Another viewer, who may hold none. It is opened first: a page that is opened may take the focus, and then the hand lets go.
  const other = await open(token('observer'));
  page = await open(readFileSync(join(state, 'local.token'), 'utf8').trim());
  await take();
  await page.keyboard.press('y');  // A look along the floor: up on the screen is up in the scene.
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const from = await place();
  assert.equal((await own()).depth, 0);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  for (let i = 1; (await own()).target[2] > -0.012; ++i) await page.mouse.move(from.x, from.y + 3 * i);
  // A hand that comes fast dips deeper than it rests: the floor lifts it again. Without the floor it would come to its target.
  await until(() => {
    const {felt, position, target} = window.feltwire().own;
    return felt > 1 && position[2] < 0 && position[2] > 0.58 * target[2];
  });
  const pressed = await own();
  assert.ok(Math.abs(pressed.proxy[2]) < 1e-4, 'the proxy stays on the floor');
  assert.ok(pressed.felt < 1.15 * STIFFNESS * pressed.depth + 0.2, `${pressed.felt} N at ${pressed.depth} m`);
  assert.ok(pressed.rods > 10, 'the spring is drawn');
  await until(() => /It feels [\d.]+ N\. The spring pulls with [\d.]+ N over [\d.]+ mm/.test(document.querySelector('#own-values').textContent));
  assert.equal(await page.textContent('#own-state'), 'You hold a hand.');

  await other.waitForFunction(() => window.feltwire().hands.length === 1 && window.feltwire().longestArrow > 0);
  assert.ok(await other.locator('#take').isHidden());

  await page.mouse.up();
  await page.getByRole('button', {name: 'Let go'}).click();
  await until(() => window.feltwire().own.state === 'free' && window.feltwire().hands.length === 0);
  assert.match(await page.textContent('#own-state'), /let go: the page let go/);
});

test('a drag on a body brings the hand to it, and pushes it', async () => {
  await serveScene(process.env.FELTWIRE_RECORDED_SCENE);
  page = await open(readFileSync(join(state, 'local.token'), 'utf8').trim());
  await page.setViewportSize({width: 1360, height: 860});  // The hand and the box lie apart by more than the reach of the hand.
  await take();
  const box = (state) => state.bodyPlaces.reduce((near, body) => (away(body.at) < away(near.at) ? body : near));  // of scenes/workshop.json
  const away = ([x, y]) => Math.hypot(x - 0.05, y + 0.03);
  await until(() => window.feltwire().bodyPlaces.length > 4 && window.feltwire().bodyPlaces.every(({at}) => Math.hypot(...at) > 0));
  const before = await page.evaluate(() => window.feltwire());
  const {index, at, x, y} = box(before);
  assert.ok(away(at) < 0.01, `${at}`);
  const {left, top} = await page.locator('#canvas').boundingBox().then((area) => ({left: area.x, top: area.y}));
  await page.mouse.move(left + x, top + y);
  await page.mouse.down();
  const {target} = await own();
  assert.ok(Math.hypot(...target.map((value, axis) => value - at[axis])) < 0.03, `${target} is on the box at ${at}`);
  const moved = ([number, from, least]) => {
    const body = window.feltwire().bodyPlaces.find((found) => found.index === number);
    return Math.hypot(...body.at.map((value, axis) => value - from[axis])) > least;
  };
  await until(() => window.feltwire().own.felt > 0.2);
  await until(moved, [index, at, 0.001]);
  for (let i = 1; i <= 12; ++i) await page.mouse.move(left + x + 4 * i, top + y);
  const dragged = (await own()).target;
  assert.ok(Math.hypot(...dragged.map((value, axis) => value - target[axis])) > 0.01);
  assert.deepEqual((await page.evaluate(() => window.feltwire())).pose, before.pose, 'the camera stays');
  await page.mouse.up();
});

test('a page with a hand: nothing is too wide, contrast is 4.5 or more, and all controls have names', async () => {
  await serve();
  for (const colorScheme of ['light', 'dark']) {
    page = await open(readFileSync(join(state, 'local.token'), 'utf8').trim());
    await page.emulateMedia({colorScheme});
    await take();
    await until(() => /^It feels/.test(document.querySelector('#own-values').textContent));
    assert.deepEqual(await overflowing(page), [], colorScheme);
    await page.keyboard.press(' ');  // Names stand still. axe-core may be so long that the hand is let go; then its texts are judged all the same.
    assert.deepEqual(await faults(page), [], colorScheme);
    await page.context().close();
  }
});

test('it has the law that is chosen when it is taken', async () => {
  await serve();
  page = await open(token('pointer'));
  await until(() => window.feltwire().own.state === 'free');
  const laws = await page.locator('#law option').allTextContents();
  assert.equal(laws[0], 'usual');
  assert.ok(laws.includes('per_axis') && laws.includes('none'));
  for (const [law, mode] of [['', 'shaped'], ['per_axis', 'per_axis'], ['none', 'none']]) {
    await page.selectOption('#law', law);
    await take();
    assert.ok(await page.locator('#law').isDisabled());
    await until((wanted) => [...document.querySelector('tbody tr')?.cells ?? []].some(({title}) => title.includes(wanted)), mode);
    await page.keyboard.press('Escape');
    await until(() => window.feltwire().own.state === 'free' && window.feltwire().hands.length === 0);
  }
});

test('keys, the wheel and a gamepad move it', async () => {
  await serve();
  page = await open(token('pointer'), () => {
    window.pad = null;
    navigator.getGamepads = () => [window.pad];
  }, 1);  // At another scale Chromium changes the distance that a wheel reports.
  await until(() => window.feltwire().own.state === 'free');
  await page.keyboard.press('g');
  await until(() => window.feltwire().own.number !== null);
  await page.keyboard.press('x');  // Right on the screen is +y in the scene.
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const before = (await own()).target;
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('Shift+ArrowUp');
  await page.keyboard.press('PageDown');
  const after = (await own()).target;
  for (const [axis, way] of [0.001, 0.001, 0.01].entries()) assert.ok(Math.abs(Math.abs(after[axis] - before[axis]) - way) < 1e-5, `${before} to ${after}`);
  await until((z) => Math.abs(window.feltwire().own.position?.[2] - z) < 1e-3, after[2]);

  const {x, y} = await place();
  await page.mouse.move(x, y);
  await page.mouse.wheel(0, 100);
  await until((from) => Math.abs(Math.abs(window.feltwire().own.target[0] - from) - 0.002) < 1e-5, after[0]);

  const [, , z] = (await own()).target;
  await page.evaluate(() => (window.pad = {connected: true, axes: [0, -1], buttons: []}));
  await until((from) => window.feltwire().own.target[2] > from + 0.005, z);
  await page.evaluate(() => (window.pad = null));
  await page.keyboard.press('Escape');
  await until(() => window.feltwire().own.state === 'free');
});

test('a tab that loses the focus lets go', async () => {
  await serve();
  page = await open(token('operator'));
  await take();
  await page.evaluate(() => dispatchEvent(new Event('blur')));
  await until(() => window.feltwire().own.state === 'free');
  await until(() => window.feltwire().hands.length === 0);
});

test('a tab that is hidden lets go', async () => {
  await serve();
  page = await open(token('operator'));
  await take();
  await page.evaluate(() => {
    Object.defineProperty(document, 'hidden', {configurable: true, get: () => true});
    document.dispatchEvent(new Event('visibilitychange'));
  });
  await until(() => window.feltwire().own.state === 'free');
  await until(() => window.feltwire().hands.length === 0);
  // A page that is shown again does not take a hand by itself.
  await page.evaluate(() => {
    delete document.hidden;
    document.dispatchEvent(new Event('visibilitychange'));
  });
  assert.equal((await own()).state, 'free');
});

test('two fingers move it away and near', async () => {
  await serve();
  page = await open(token('operator'));
  await take();
  await page.keyboard.press('x');  // The camera looks along -x.
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const {x, y} = await place();
  const devtools = await page.context().newCDPSession(page);
  const touch = (type, ...across) => devtools.send('Input.dispatchTouchEvent', {type, touchPoints: across.map((at, id) => ({x: x + at, y, id}))});
  const [start] = (await own()).target;
  await touch('touchStart', 0);
  await touch('touchStart', 0, 30);
  for (let apart = 30; apart <= 90; apart += 10) await touch('touchMove', 0, apart);
  await until((from) => window.feltwire().own.target[0] < from - 1e-3, start);
  const [away] = (await own()).target;
  for (let apart = 90; apart >= 30; apart -= 10) await touch('touchMove', 0, apart);
  await until(([from, to]) => window.feltwire().own.target[0] > from + 0.8 * (to - from), [away, start]);
  await touch('touchEnd');
  assert.equal((await own()).state, 'held');
});

test('a server that lends no hands shows no button', async () => {
  await serve('--web-hands', '0');
  page = await open(token('operator'));
  await until(() => window.feltwire().scene !== '');
  assert.ok(await page.locator('#take').isHidden());
});
