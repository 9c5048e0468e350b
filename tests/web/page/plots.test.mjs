// The plots of the live page: time, values, several hands, files. Every wait is for a condition.

import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {test} from 'node:test';
import {bits} from './members.mjs';
import {hold, newPage, newServer, open, page, press, server, state, until} from './page_fixture.mjs';

/** Opens the page with this many hands, and waits until there is something to plot. */
async function begin(hands = 2, options = {viewport: {width: 1360, height: 860}}) {
  await newServer({hands});
  await newPage({deviceScaleFactor: 1, ...options});
  await open();
  await until(() => window.feltwire().plotted.points > 30 && window.feltwire().chosen === 1);
}

const drawing = async () => page.locator('#plots .u-over').first().boundingBox();
const span = ([from, to]) => to - from;

test('the wheel zooms about the pointer and holds the picture, a drag moves, and both end with Go on', async () => {
  await begin();
  const {x, y, width, height} = await drawing();
  await page.mouse.move(x + 0.75 * width, y + height / 2);
  await page.mouse.wheel(0, -400);
  await until(() => window.feltwire().held);
  const zoomed = (await state()).plotted;
  assert.ok(span(zoomed.range) < 5, `${zoomed.range}`);
  const at = zoomed.end - 10 + 0.75 * 10;  // It stays under the pointer.
  assert.ok(Math.abs(zoomed.range[0] + 0.75 * span(zoomed.range) - at) < 0.1, `${zoomed.range}, not ${at}`);
  await page.mouse.down();
  await page.mouse.move(x + 0.25 * width, y + height / 2, {steps: 4});
  await page.mouse.up();
  const moved = (await state()).plotted;
  assert.ok(Math.abs(span(moved.range) - span(zoomed.range)) < 1e-6);
  assert.ok(Math.abs(moved.range[0] - zoomed.range[0] - 0.5 * span(zoomed.range)) < 0.1 * span(zoomed.range), `${zoomed.range} to ${moved.range}`);
  await page.click('#hold');
  await until(() => !window.feltwire().held && window.feltwire().plotted.range[1] === window.feltwire().plotted.end);
  assert.ok(Math.abs(span((await state()).plotted.range) - 10) < 1e-6);
});

test('keys zoom and move the time, and the choice of seconds goes back to its end', async () => {
  await begin();
  await press(']');
  await until(() => window.feltwire().held);
  const {range: first} = (await state()).plotted;
  assert.ok(Math.abs(span(first) - 10 / 1.5) < 1e-6);
  await press('<');
  const {range: second} = (await state()).plotted;
  assert.ok(Math.abs(first[0] - second[0] - 0.2 * span(first)) < 1e-6);
  await page.selectOption('#seconds', '5');
  const {range: [from, to], end} = (await state()).plotted;
  assert.deepEqual([to, Math.round(1000 * (to - from))], [end, 5000]);
});

test('the values under the pointer are written, with their time', async () => {
  await begin();
  await until(() => window.feltwire().plotted.points > 150);  // Some 2.5 s of them.
  await hold();
  const {x, y, width, height} = await drawing();
  await page.mouse.move(x + 0.9 * width, y + height / 2);
  await until(() => /^at −1(\.\d+)? s$/.test(document.querySelector('#plot-time').textContent));
  const shown = await page.locator('#plots .legend b').allTextContents();
  await page.mouse.move(x + 0.97 * width, y + height / 2);
  await until(() => /^at −0\.\d+ s$/.test(document.querySelector('#plot-time').textContent));
  assert.notDeepEqual(await page.locator('#plots .legend b').allTextContents(), shown);
  await page.mouse.move(5, 5);
  await until(() => document.querySelector('#plot-time').textContent === '');
});

test('several hands are plotted over each other; what one does not know hides nothing of the others', async () => {
  await begin(4);
  await press('m');
  assert.equal(await page.getAttribute('#compare', 'aria-pressed'), 'true');
  const names = () => page.locator('#plots .plot').first().locator('.legend span').evaluateAll((items) => items.map((item) => item.firstChild.nextSibling.textContent.trim()));
  assert.deepEqual(await names(), ['alice', 'bob', 'carol', 'dave']);
  await until(() => window.feltwire().plotted.last[3].length === 4 && Math.abs(window.feltwire().plotted.last[3][2] - 5.1) < 0.5);
  await until(() => window.feltwire().plotted.tops[3] >= 5);  // [ms] dave's round trip is unknown.
  await press('2');
  assert.deepEqual(await names(), ['bob', 'alice', 'carol', 'dave']);
  await press('m');
  assert.deepEqual(await names(), ['elastic', 'friction', 'commanded', 'rendered']);
});

test('of more than eight hands the chosen one and seven others are plotted', async () => {
  await begin(12);
  await press('m');
  await press('0');
  await until(() => window.feltwire().chosen === 10 && window.feltwire().plotted.last[0].length === 8);
  assert.match(await page.locator('#plots .legend span').first().textContent(), /^guest9/);
});

test('while the picture is held nothing is plotted, and the line has a gap after it', async () => {
  await begin();
  await hold();
  const {plotted: {end}} = await state();
  await until((time) => window.feltwire().pictures > time, (await state()).pictures + 90);  // More than a second of them.
  assert.equal((await state()).plotted.end, end);
  assert.equal((await state()).plotted.gaps, 0);
  await press(' ');
  await until(() => window.feltwire().plotted.gaps === 1);
});

/** @returns {Promise<[string, Buffer]>} name and content of the file that a key saves */
async function saved(key) {
  const [download] = await Promise.all([page.waitForEvent('download'), press(key)]);
  return [download.suggestedFilename(), readFileSync(await download.path())];
}

test('the values are saved as CSV: of the time that is shown, and of every hand that is compared', async () => {
  await begin();
  await until(() => window.feltwire().plotted.points > 250);  // Some 4 s of them.
  await press(']');
  await until(() => window.feltwire().held);
  const {range: [from, to], last} = (await state()).plotted;
  const [name, content] = await saved('v');
  assert.match(name, /^feltwire-room-alice-.*\.csv$/);
  const [head, ...rows] = content.toString().trimEnd().split('\n').map((row) => row.split(','));
  assert.deepEqual(head.slice(0, 7), ['time_s', 'hand', 'client', 'elastic_N', 'friction_N', 'commanded_N', 'rendered_N']);
  assert.ok(rows.length > 5 && rows.every((row) => row.length === head.length && row[2] === 'alice' && Number(row[0]) >= from - 1e-6 && Number(row[0]) <= to + 1e-6));
  await press('>');
  await press('>');
  const [, later] = await saved('v');
  const newest = later.toString().trimEnd().split('\n').at(-1).split(',');
  assert.ok(Math.abs(Number(newest[6]) - last[0][3]) < 1e-3 || Number(newest[0]) > to, newest.join());
  await press('m');
  const [whole, both] = await saved('v');
  assert.match(whole, /^feltwire-room-2/);
  assert.deepEqual([...new Set(both.toString().trimEnd().split('\n').slice(1).map((row) => row.split(',')[2]))], ['alice', 'bob']);
});

test('the plots are saved as one image', async () => {
  await begin();
  await hold();
  const [name, content] = await saved('b');
  assert.match(name, /^feltwire-room-alice-.*\.png$/);
  const {width, height, counts} = await page.evaluate(async (base64) => {
    const image = new Image();
    image.src = `data:image/png;base64,${base64}`;
    await image.decode();
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const {data} = context.getImageData(0, 0, canvas.width, canvas.height);
    const count = (variable) => {
      const wanted = getComputedStyle(document.documentElement).getPropertyValue(variable).trim();
      const color = [1, 3, 5].map((at) => parseInt(wanted.slice(at, at + 2), 16));
      let found = 0;
      for (let i = 0; i < data.length; i += 4) if (color.every((value, k) => Math.abs(data[i + k] - value) < 16)) found += 1;
      return found;
    };
    return {width: canvas.width, height: canvas.height, counts: ['--panel', '--elastic', '--rendered', '--ink', '--friction'].map(count)};
  }, content.toString('base64'));
  const {width: room} = await page.locator('#plots .drawing').first().boundingBox();
  assert.ok(Math.abs(width - room) < 2 && height > 400, `${width} x ${height}`);
  assert.ok(counts[0] > 10_000 && counts.slice(1).every((count) => count > 50), counts.join());
});

test('a force above what the scene asks for is explained', async () => {
  server.play.over = 1.5;
  server.play.reasons = bits('touching');
  await open();
  await until(() => /: 1[2-5]\d %, because the device still answers an earlier position\.$/.test(document.querySelector('#sentence').title.replace(/ Its shaping.*/, '')));
  server.play.reasons = bits('touching', 'near');
  await until(() => /%, because its client computes the force by itself, at a newer position\./.test(document.querySelector('#sentence').textContent));
  server.play.over = 5;
  await until(() => /: more than 3 times as much, because/.test(document.querySelector('#sentence').textContent));
  assert.match(await page.locator('#plots .plot').nth(2).locator('.legend').textContent(), /given to the hand/);
});

test('two fingers zoom the time on a phone, and one moves it', async () => {
  await begin(2, {viewport: {width: 390, height: 800}, isMobile: true, hasTouch: true});
  await page.locator('#plots .u-over').first().scrollIntoViewIfNeeded();
  const {x, y, width, height} = await drawing();
  const devtools = await page.context().newCDPSession(page);
  const touch = (type, ...shares) => devtools.send('Input.dispatchTouchEvent', {type, touchPoints: shares.map((share, id) => ({id, x: x + share * width, y: y + height / 2}))});
  await touch('touchStart', 0.4, 0.6);
  for (const spread of [0.15, 0.2, 0.3, 0.4]) await touch('touchMove', 0.5 - spread, 0.5 + spread);
  await touch('touchEnd');
  await until(() => window.feltwire().held);
  const {range: zoomed} = (await state()).plotted;
  assert.ok(span(zoomed) < 5 && span(zoomed) > 1, `${zoomed}`);
  await touch('touchStart', 0.3);
  for (const share of [0.4, 0.5, 0.6]) await touch('touchMove', share);
  await touch('touchEnd');
  await until((from) => window.feltwire().plotted.range[0] < from, zoomed[0] - 0.15 * span(zoomed));
  assert.ok(Math.abs(span((await state()).plotted.range) - span(zoomed)) < 1e-6);
});
