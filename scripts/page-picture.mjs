#!/usr/bin/env node
// Makes a picture of the live page in headless Chromium, once hands are on it:
//   scripts/page-picture.mjs URL FILE.png [HANDS [SECONDS [MORE]]]
// waits until HANDS (default 1) are shown, for a minute at most, and SECONDS (default 3) more, for the plots. MORE
// (default 0) pictures follow, FILE-1.png and so on, each after the page has drawn again. It fails if a hand leaves before. It
// prints how long the page took from its request to the first picture that was drawn, in a new browser that has opened no page yet and once more.
// It speaks to Chromium by a pipe (the DevTools protocol) and needs no package of npm.

import {spawn} from 'node:child_process';
import {mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {setTimeout as pause} from 'node:timers/promises';

const PATIENCE = 60_000;  // [ms]
const REST = 500, RESTS = 0.05;  // [ms], [s] a browser rests when it uses no more processor time than that in this time
const [url, file, hands = '1', seconds = '3', more = '0'] = process.argv.slice(2);
if (!file) {
  console.error('usage: scripts/page-picture.mjs URL FILE.png [HANDS [SECONDS [MORE]]]');
  process.exit(2);
}

const folder = mkdtempSync(join(tmpdir(), 'feltwire-page-'));
const sandbox = process.getuid() === 0 ? ['--no-sandbox'] : [];
const browser = spawn(
  process.env.FELTWIRE_CHROMIUM ?? 'chromium',
  ['--headless', ...sandbox, '--remote-debugging-pipe', `--user-data-dir=${folder}`, '--window-size=1360,860', 'about:blank'],
  {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});
const [toBrowser, fromBrowser] = [browser.stdio[3], browser.stdio[4]];
const answers = new Map();
let next = 0;
let came = '';
fromBrowser.setEncoding('utf8').on('data', (text) => {
  const messages = (came + text).split('\0');
  came = messages.pop();
  for (const {id, result, error} of messages.map((message) => JSON.parse(message))) {
    const answer = answers.get(id);
    if (error) answer?.reject(new Error(error.message));
    else answer?.resolve(result);
  }
});
const failed = new Promise((_, reject) => {
  browser.on('error', reject).on('exit', () => reject(new Error('Chromium ended')));
});

/** Sends a command of the DevTools protocol and waits for its answer. */
function ask(method, params = {}, sessionId = undefined) {
  const id = ++next;
  const answer = new Promise((resolve, reject) => answers.set(id, {resolve, reject}));
  toBrowser.write(`${JSON.stringify({id, method, params, sessionId})}\0`);
  return Promise.race([answer, failed]);
}

/** Waits until a browser that has just begun has loaded what is its own, which takes about as much time as the page: until it rests. */
async function settle() {
  const used = async () => (await ask('SystemInfo.getProcessInfo')).processInfo.reduce((sum, {cpuTime}) => sum + cpuTime, 0);  // [s]
  const latest = Date.now() + PATIENCE;
  for (let before = -1, now = await used(); now - before > RESTS && Date.now() < latest; [before, now] = [now, await used()]) await pause(REST);
}

/** Opens the page in a tab of its own. */
async function open() {
  const {targetId} = await ask('Target.createTarget', {url});
  const {sessionId} = await ask('Target.attachToTarget', {targetId, flatten: true});
  return {targetId, sessionId};
}

/** What an expression is in the page; undefined before the page is there. */
async function evaluate(expression, sessionId) {
  const answer = await ask('Runtime.evaluate', {expression}, sessionId).catch(() => undefined);
  if (browser.exitCode !== null) throw new Error('Chromium ended');
  return answer?.result?.value;
}

/** What the page shows: hands, and the number of frames that it has drawn. */
async function shown(sessionId) {
  const [count, frames] = (await evaluate('window.feltwire ? [feltwire().hands.length, feltwire().frames].join() : "0,0"', sessionId) ?? '0,0').split(',').map(Number);
  return {count, frames};
}

/** Makes a picture of the page, once it has drawn again. @param {string} name of its file */
async function take(name, sessionId) {
  const before = await shown(sessionId);
  for (const latest = Date.now() + PATIENCE; ; await pause(20)) {
    const {count, frames} = await shown(sessionId);
    if (count < Number(hands)) throw new Error(`the page shows ${count} of ${hands} hands for ${name}: let the hands stay until it ends`);
    if (frames > before.frames) break;
    if (Date.now() > latest) throw new Error(`the page drew nothing new for ${name} in 60 s`);
  }
  const {data} = await ask('Page.captureScreenshot', {format: 'png'}, sessionId);
  writeFileSync(name, Buffer.from(data, 'base64'));
}

/** @returns {Promise<number>} [ms] from the page's request to the first picture that was drawn */
async function firstPicture(sessionId) {
  for (const latest = Date.now() + PATIENCE; Date.now() < latest; await pause(100)) {
    const time = await evaluate('window.feltwire?.().firstPicture ?? 0', sessionId);
    if (time > 0) return Math.round(time);
  }
  throw new Error('no picture was drawn in 60 s');
}

try {
  await settle();
  const {targetId, sessionId} = await open();
  await ask('Emulation.setDeviceMetricsOverride', {width: 1360, height: 860, deviceScaleFactor: 1, mobile: false}, sessionId);
  const latest = Date.now() + PATIENCE;
  for (let count = 0; count < Number(hands); await pause(100)) {
    if (Date.now() > latest) {
      const said = await evaluate('document.querySelector("#state span").textContent', sessionId);
      throw new Error(`the page shows ${count} of ${hands} hands after 60 s, and says: ${said}`);
    }
    ({count} = await shown(sessionId));
  }
  await pause(1000 * Number(seconds));
  const first = await firstPicture(sessionId);
  await take(file, sessionId);
  for (let i = 1; i <= Number(more); ++i) {
    await take(file.replace(/(\.png)?$/, `-${i}$1`), sessionId);
  }
  await ask('Target.closeTarget', {targetId});
  console.log(`first picture: ${first} ms after the page was asked for; again: ${await firstPicture((await open()).sessionId)} ms`);
} catch (error) {
  console.error(`page-picture: ${error.message}`);
  process.exitCode = 1;
} finally {
  failed.catch(() => {});
  browser.kill();
  await new Promise((resolve) => (browser.exitCode ?? browser.signalCode) !== null ? resolve() : browser.once('exit', resolve));
  try {
    rmSync(folder, {recursive: true, force: true, maxRetries: 5});
  } catch {  // A child of the browser still writes to it: what is left is the system's to remove.
  }
}
