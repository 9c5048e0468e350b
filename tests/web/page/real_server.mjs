// A real server and a browser, for tests of the page. FELTWIRE_PROGRAMS: the folder of the programs.

import assert from 'node:assert/strict';
import {execFileSync, spawn} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {createInterface} from 'node:readline';
import {after, afterEach, before, beforeEach} from 'node:test';
import {chromium} from 'playwright-core';

const PATIENCE = 120_000;  // [ms] for a machine that draws in software and has more to do
const program = join(process.env.FELTWIRE_PROGRAMS, 'feltwire-server');
export let state;
let served;
let address;
export let control;  // its port for clients
let browser;
let complaints;

before(async () => {
  browser = await chromium.launch({executablePath: process.env.FELTWIRE_CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox']});
});
after(() => browser.close());

beforeEach(() => {
  state = mkdtempSync(join(tmpdir(), 'feltwire-page-'));
  complaints = [];
});
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
  const ended = new Promise((resolve) => served.once('exit', resolve));
  served.kill();
  await ended;
  rmSync(state, {recursive: true, force: true});
  assert.deepEqual(complaints, []);
});

/** @param {string} scene file @param {string[]} more options @returns {Promise<void>} once the page is served */
export async function serve(scene, ...more) {
  served = spawn(program, ['--scene', scene, '--port', '0', '--web', '0', '--state', state, ...more], {stdio: ['ignore', 'pipe', 'inherit']});
  for await (const line of createInterface({input: served.stdout})) {
    control = /^listening: control tcp (\d+)/.exec(line)?.[1] ?? control;
    address = /^live page: (\S+)/.exec(line)?.[1];
    if (address) break;
  }
  assert.ok(address, 'the server ended');
  served.stdout.resume();
}

/** @param {string} role @returns {string} a new token of the server */
export function token(role) {
  const words = ['token', 'add', '--client', role, '--role', role, '--scene', '*', '--expires', '1h', '--state', state];
  return /fw_\S+/.exec(execFileSync(program, words, {encoding: 'utf8'}))[0];
}

/** @returns {string} the server's own token of this role, local or admin */
export const ownToken = (name) => readFileSync(join(state, `${name}.token`), 'utf8').trim();

/** Opens the page. Half of the pixels each way: they are drawn in software. @param {string} shown token @param {object} options of the browser's context */
export async function open(shown, options = {}) {
  const context = await browser.newContext({viewport: {width: 900, height: 640}, deviceScaleFactor: 0.5, ...options});
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  page.on('pageerror', (error) => complaints.push(error.stack));
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
  await page.goto(`${address}#token=${shown}`);
  await page.waitForFunction(() => window.feltwire?.().connection === 'live');
  return page;
}
