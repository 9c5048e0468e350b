// A browser and a server that is played, for tests of the page. Whoever imports this has both anew for each test.

import assert from 'node:assert/strict';
import {after, afterEach, before, beforeEach} from 'node:test';
import {chromium} from 'playwright-core';
import {startServer, TOKEN} from './mock_server.mjs';

export const folder = process.env.FELTWIRE_PAGE;
const PATIENCE = 120_000;  // [ms] for a machine that draws in software and has more to do
let browser;
export let server;
export let page;
let complaints;
let foreign;

before(async () => {
  const executablePath = process.env.FELTWIRE_CHROMIUM ?? '/usr/bin/chromium';
  browser = await chromium.launch({executablePath, args: ['--no-sandbox']});
});
after(() => browser.close());

beforeEach(async () => {
  server = await startServer({folder});
  complaints = [];
  foreign = [];
  page = await makePage();
});

afterEach(async () => {
  await page.context().close();
  await server.stop();
  assert.deepEqual(complaints, []);
  assert.deepEqual(foreign, [], 'requests to other hosts');
});

/** Half of the pixels each way: they are drawn in software. */
async function makePage(options = {}) {
  const context = await browser.newContext({viewport: {width: 900, height: 640}, deviceScaleFactor: 0.5, ...options});
  const made = await context.newPage();
  made.setDefaultTimeout(PATIENCE);
  made.on('pageerror', (error) => complaints.push(error.stack));
  made.on('console', (message) => {
    const text = message.text();
    // Without a server a connection fails, and Chromium says so.
    if (message.type() === 'error' && !/WebSocket connection to .* failed/.test(text)) complaints.push(text);
  });
  made.on('request', (request) => {
    if (!request.url().startsWith(server.url) && !request.url().startsWith('data:')) foreign.push(request.url());
  });
  return made;
}

export const open = async (token = TOKEN) => page.goto(`${server.url}#token=${token}`);
export const until = (condition, argument) => page.waitForFunction(condition, argument);
export const state = () => page.evaluate(() => window.feltwire());
export const press = (key) => page.keyboard.press(key);

/** Holds the picture, and waits until the last that came before is drawn. */
export async function hold() {
  await press(' ');
  await until(() => window.feltwire().held);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

/** Pixels of the 3D view that have nearly this color of the theme. */
export async function pixels(name) {
  const picture = await page.locator('#canvas').screenshot();
  return page.evaluate(async ([base64, variable]) => {
    const image = new Image();
    image.src = `data:image/png;base64,${base64}`;
    await image.decode();
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const {data} = context.getImageData(0, 0, image.width, image.height);
    const wanted = getComputedStyle(document.documentElement).getPropertyValue(variable).trim();
    const [r, g, b] = [1, 3, 5].map((at) => parseInt(wanted.slice(at, at + 2), 16));
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) < 24) count += 1;
    }
    return count;
  }, [picture.toString('base64'), `--${name}`]);
}

/** Takes the complaints that the browser must have made by now. @param {RegExp} of all of them */
export function forgive(of) {
  assert.notEqual(complaints.length, 0);
  for (const complaint of complaints) assert.match(complaint, of);
  complaints = [];
}

/** Closes the page and makes another. @param {object} options of the browser's context */
export async function newPage(options) {
  await page.context().close();
  page = await makePage(options);
}

/** Starts a server where the last one was stopped. @param {object} options of startServer */
export async function startAnotherServer(options) {
  server = await startServer({folder, ...options});
}

/** Stops the server and starts another. @param {object} options of startServer */
export async function newServer(options) {
  await server.stop();
  await startAnotherServer(options);
}
