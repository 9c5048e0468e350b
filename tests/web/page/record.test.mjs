// A scene that is recorded on the page of a real server, with a real client in it. Every wait is for a condition.
// FELTWIRE_PROGRAMS: the folder of the programs. FELTWIRE_RECORDED_SCENE: a scene with an object that moves.

import assert from 'node:assert/strict';
import {execFileSync, spawn} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync, statSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {createInterface} from 'node:readline';
import {after, before, test} from 'node:test';
import {chromium} from 'playwright-core';

const PATIENCE = 60_000;  // [ms] for a machine that draws in software and has more to do
const program = (name) => join(process.env.FELTWIRE_PROGRAMS, name);
const started = [];
let state;
let address;
let browser;
let page;
let complaints;

/** Starts a program. @returns {Promise<string[]>} for each of the patterns what it found in the program's lines, once all are found */
async function start(name, options, patterns) {
  const process = spawn(program(name), options, {stdio: ['ignore', 'pipe', 'inherit']});
  started.push(process);
  const found = [];
  for await (const line of createInterface({input: process.stdout})) {
    patterns.forEach((pattern, i) => (found[i] ??= pattern.exec(line)?.[1]));
    if (patterns.every((_, i) => found[i])) break;
  }
  process.stdout.resume();
  return found;
}

before(async () => {
  state = mkdtempSync(join(tmpdir(), 'feltwire-record-'));
  const [port, web] = await start('feltwire-server', ['--scene', process.env.FELTWIRE_RECORDED_SCENE, '--port', '0', '--web', '0', '--state', state, '--recordings', join(state, 'recordings')],
    [/^listening: control tcp (\d+)/, /^live page: (\S+)/]);
  address = web;
  spawnClient(port);
  browser = await chromium.launch({executablePath: process.env.FELTWIRE_CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox']});
  page = await (await browser.newContext({viewport: {width: 900, height: 640}, deviceScaleFactor: 0.5})).newPage();
  page.setDefaultTimeout(PATIENCE);
  complaints = [];
  page.on('pageerror', (error) => complaints.push(error.stack));
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
});

after(async () => {
  await browser?.close();
  for (const process of started.reverse()) {
    const ended = new Promise((resolve) => process.once('exit', resolve));
    process.kill();
    await ended;
  }
  rmSync(state, {recursive: true, force: true});
  assert.deepEqual(complaints, []);
});

function spawnClient(port) {
  started.push(spawn(program('feltwire-client'), ['--connect', `127.0.0.1:${port}`, '--fingerprint-file', join(state, 'fingerprint'),
    '--token-file', join(state, 'local.token'), '--scene', 'workshop', '--device', 'simulated:path=taps', '--duration', '600'], {stdio: 'ignore'}));
}

const until = (condition, argument) => page.waitForFunction(condition, argument);

test('the page records the scene: the file is read by the laboratory, and shown with the scene', async () => {
  await page.goto(`${address}#token=${readFileSync(join(state, 'local.token'), 'utf8').trim()}`);
  await until(() => window.feltwire?.().hands.length === 1 && window.feltwire().longestArrow > 0);
  await page.keyboard.press('r');
  assert.equal(await page.getAttribute('#foxglove', 'open'), null);  // Its ticket is for the recording.
  await until(() => window.feltwire().recorded > 3);
  assert.match(await page.textContent('#record'), /^Stop \d+ s$/);
  const {bodies, solids} = await page.evaluate(() => window.feltwire());
  await page.click('#record');
  await until(() => /^Recorded \d+\.\d s of workshop, \d+\.\d MB\./.test(document.querySelector('#recorded span').textContent));
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#recorded-save')]);
  assert.match(download.suggestedFilename(), /^feltwire-workshop-.*\.mcap$/);
  const file = join(state, 'workshop.mcap');
  await download.saveAs(file);

  const tables = join(state, 'tables');
  execFileSync(program('feltwire-lab'), ['export', file, '--csv', tables]);
  const [head, ...rows] = readFileSync(join(tables, 'scene_hand_1.csv'), 'utf8').trim().split('\n').map((row) => row.split(','));
  const times = rows.map((row) => Number(row[head.indexOf('t')]));
  assert.ok(rows.length > 60 && times.at(-1) > 2.5 && times.every((time, i) => i === 0 || time >= times[i - 1]), `${rows.length} rows, up to ${times.at(-1)} s`);
  assert.ok(rows.some((row) => Math.hypot(...['rx', 'ry', 'rz'].map((name) => Number(row[head.indexOf(name)]))) > 0.1), 'some force is held');

  await page.click('#recorded-open');
  await until(() => window.feltwire().replay.stages.length === 1 && window.feltwire().replay.stages[0].read && window.feltwire().replay.drawn);
  const {stages: [stage]} = (await page.evaluate(() => window.feltwire())).replay;
  assert.deepEqual([stage.hands, stage.troubles], [[1], []]);
  assert.ok(Math.abs(stage.duration - times.at(-1)) < 0.5, `${stage.duration} s, not ${times.at(-1)}`);
  assert.deepEqual([stage.bodies, stage.solids], [bodies, solids.length]);
});

test('an admin records at the server: the file is saved, read by the laboratory, and shown', async () => {
  await page.goto('about:blank');
  await page.goto(`${address}#token=${readFileSync(join(state, 'admin.token'), 'utf8').trim()}`);
  await until(() => window.feltwire?.().hands.length === 1 && window.feltwire().longestArrow > 0);
  const {bodies, solids} = await page.evaluate(() => window.feltwire());
  assert.ok(bodies > 0 && solids.length > 0);
  await page.click('#admin-open');
  await page.click('#admin-scene-tab');
  await page.click('#server-record');
  await until(() => Number(/^Records since (\d+) s/.exec(document.querySelector('#server-record-state').textContent)?.[1]) > 2);
  await page.click('#server-record');
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#admin .recordings li button:first-of-type')]);
  assert.match(download.suggestedFilename(), /^recording-\d{8}T\d{6}\.\d{3}Z-workshop\.mcap$/);
  const file = join(state, 'served.mcap');
  await download.saveAs(file);
  assert.deepEqual(readFileSync(file), readFileSync(join(state, 'recordings', download.suggestedFilename())));
  assert.equal(statSync(join(state, 'recordings', download.suggestedFilename())).mode & 0o777, 0o600);
  const tables = join(state, 'served');
  execFileSync(program('feltwire-lab'), ['export', file, '--csv', tables]);
  assert.ok(readFileSync(join(tables, 'hand_1_sample.csv'), 'utf8').split('\n').length > 1000);

  await page.click('#admin .recordings li button:last-of-type');
  await until(() => window.feltwire().replay.stages.length === 1 && window.feltwire().replay.stages[0].read && window.feltwire().replay.drawn);
  const {stages: [stage]} = (await page.evaluate(() => window.feltwire())).replay;
  assert.deepEqual([stage.hands, stage.troubles], [[1], []]);
  assert.ok(stage.duration > 2, `${stage.duration} s`);
  assert.deepEqual([stage.bodies, stage.solids], [bodies, solids.length]);  // The scene is in the file.
  assert.ok(stage.bodyPlaces.every(({at}) => Math.hypot(...at) > 1e-6), JSON.stringify(stage.bodyPlaces));
});
