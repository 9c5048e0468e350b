// The live page in a browser. Every wait is for a condition.

import assert from 'node:assert/strict';
import {after, afterEach, before, beforeEach, test} from 'node:test';
import {chromium} from 'playwright-core';
import {ADMIN, startServer, TOKEN} from './mock_server.mjs';

const folder = process.env.FELTWIRE_PAGE;
const PATIENCE = 60_000;  // [ms] for a machine that draws in software and has more to do
let browser;
let server;
let page;
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
  page = await newPage();
});

afterEach(async () => {
  await page.context().close();
  await server.stop();
  assert.deepEqual(complaints, []);
  assert.deepEqual(foreign, [], 'requests to other hosts');
});

async function newPage(options = {}) {
  const context = await browser.newContext({viewport: {width: 900, height: 640}, ...options});
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

const open = async (token = TOKEN) => page.goto(`${server.url}#token=${token}`);
const until = (condition, argument) => page.waitForFunction(condition, argument);
const state = () => page.evaluate(() => window.feltwire());
const press = (key) => page.keyboard.press(key);

/** Holds the picture, and waits until the last that came before is drawn. */
async function hold() {
  await press(' ');
  await until(() => window.feltwire().held);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

/** Pixels of the 3D view that have nearly this color of the theme. */
async function pixels(name) {
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

test('the first picture comes, and the token leaves the address', async () => {
  await open();
  await until(() => window.feltwire().pictures > 5 && window.feltwire().frames > 2);
  assert.equal(await page.textContent('#state span'), 'Live');
  assert.equal(new URL(page.url()).hash, '');
  assert.deepEqual((await state()).hands, [1, 2]);
  assert.equal((await state()).bodies, 1);
  assert.ok(server.requests.every((path) => !path.includes(TOKEN)));
  await page.reload();  // The token is remembered for the session.
  await until(() => window.feltwire().pictures > 0);
});

test('nothing is drawn before there is a scene', async () => {
  await page.goto(server.url);
  await page.locator('#token-text').waitFor();
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))));
  assert.equal((await state()).frames, 0);
  await page.fill('#token-text', TOKEN);
  await press('Enter');
  await until(() => window.feltwire().firstPicture !== null);
});

test('a scene without pictures is drawn all the same', async () => {
  server.play.silent = true;
  await open();
  await until(() => window.feltwire().frames > 0);
  assert.equal((await state()).pictures, 0);
});

test('the view has the background of the theme', async () => {
  await open();
  await until(() => window.feltwire().firstPicture !== null);
  const area = await page.evaluate(() => document.querySelector('#canvas').clientWidth * document.querySelector('#canvas').clientHeight);
  for (let theme = 0; theme < 2; ++theme) {
    const share = (await pixels('view')) / area;
    assert.ok(share > 0.2, `${share} of the view`);
    const frames = (await state()).frames;
    await press('l');
    await until((drawn) => window.feltwire().frames > drawn, frames);
  }
});

test('arrows move and are seen', async () => {
  server.play.still = true;
  await open();
  await until(() => window.feltwire().pictures > 5 && window.feltwire().frames > 2 && window.feltwire().longestArrow === 0);
  const legend = await pixels('elastic');
  server.play.still = false;
  await until(() => window.feltwire().longestArrow > 0.03);
  await hold();
  const short = await pixels('elastic') - legend;
  assert.ok(short > 30, `${short} pixels`);
  const {frames} = await state();
  await press('.');
  await until((before) => window.feltwire().frames > before, frames);
  assert.equal(await page.textContent('#arrow-scale'), '1 N = 5 cm');
  const long = await pixels('elastic') - legend;
  assert.ok(long > 1.3 * short, `${long} pixels after ${short}`);
});

test('tools and local models are drawn', async () => {
  await open();
  await until(() => window.feltwire().toolBalls === 1 && window.feltwire().toolPoints === 60 && window.feltwire().surfaces === 1);
  await press('s');
  await until(() => window.feltwire().surfaces === 0);
  await press('s');
  await until(() => window.feltwire().surfaces === 1);
  server.play.modelled = false;
  await until(() => window.feltwire().surfaces === 0);
});

test('robots are drawn and described', async () => {
  await open();
  await until(() => window.feltwire().pictures > 1);
  const described = (lines) => until((lines) => lines === [...document.querySelectorAll('#robots p:not([hidden])')].map((line) => line.textContent).join('; '), lines.join('; '));
  assert.deepEqual((await state()).robots, []);
  await described([]);
  server.play.robots = [{state: 2, hand: 1, flags: 1 | 2 | 8}];
  await until(() => window.feltwire().robots[0]?.forces === 1);
  await described(['robot: engaged led by hand 1, 5.00 N on its tool, touches']);
  const near = (a, b) => a.every((value, i) => Math.abs(value - b[i]) < 1e-6);
  const {robots: [robot]} = await state();
  assert.ok(near(robot.tool, [0.02, 0.03, 0.04]) && near(robot.target, [0.02, 0.03, 0.02]), JSON.stringify(robot));
  server.play.robots = [{state: 5, hand: 0, flags: 4}];
  await until(() => window.feltwire().robots[0]?.forces === 0);
  await described(['robot: fault led by no hand, senses no force, protective stop']);

  server.play.seats = ['left', 'right'];
  server.play.robots = [{state: 1, hand: 0, flags: 2}, {state: 2, hand: 3, flags: 1 | 2 | 1 << 8}];
  await open();
  await until(() => window.feltwire().robots.length === 2);
  await described(['robot left: ready led by no hand, senses no force', 'robot right: engaged led by hand 3, 5.00 N on its tool']);
  server.play.robots = [{state: 2, hand: 3, flags: 1 | 2 | 1 << 8}];  // the left one has left
  await until(() => window.feltwire().robots.length === 1);
  await described(['robot right: engaged led by hand 3, 5.00 N on its tool']);
  server.play.seats = [''];
  server.play.robots = [];
  await until(() => window.feltwire().robots.length === 0);
  await described([]);
});

test('choosing a hand changes plots, strip and table', async () => {
  await open();
  await until(() => window.feltwire().plotted.points > 5 && document.querySelector('tbody tr'));
  await until(() => document.querySelector('#chosen').textContent.includes('alice'));
  await press('2');
  await until(() => window.feltwire().chosen === 2 && document.querySelector('#chosen').textContent.includes('bob'));
  await until(() => Math.abs(window.feltwire().plotted.last[3][1] - 1.3) < 1e-3);  // bob's loss
  assert.equal(await page.textContent('tr[aria-selected="true"] td:nth-child(2)'), 'bob');
  await page.locator('tbody tr').first().click();
  await until(() => window.feltwire().chosen === 1 && Math.abs(window.feltwire().plotted.last[3][1]) < 1e-3);
  await hold();  // Hands stand still for the click.
  const {places} = await state();
  const bob = places.find(({number}) => number === 2);
  await page.locator('#canvas').click({position: {x: bob.x, y: bob.y}});
  await until(() => window.feltwire().chosen === 2);
});

test('a click on a hand chooses it, also where a name lies over it', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3 && document.querySelectorAll('#labels div:not(.axis)').length > 1);
  await press('1');
  await until(() => window.feltwire().chosen === 1);
  await hold();
  const {places} = await state();
  const bob = places.find(({number}) => number === 2);
  // The name of alice is made so large that it covers the view.
  await page.locator('#labels div', {hasText: 'alice'}).evaluate((label) => label.style.cssText += 'left:-2000px;top:-2000px;width:4000px;height:4000px');
  await page.locator('#canvas').click({position: {x: bob.x, y: bob.y}});
  await until(() => window.feltwire().chosen === 2);
  await page.locator('#canvas').click({position: {x: 3, y: 3}});
  await until(() => window.feltwire().chosen === 1);
});

test('the strip says why', async () => {
  await open();
  await until(() => [...document.querySelectorAll('#reasons li')].some((item) => !item.hidden && /no more force/.test(item.textContent)));
  await until(() => /The scene asks for .* N, and the device renders .* N/.test(document.querySelector('#sentence').textContent));
  await until(() => /touches nothing/.test(document.querySelector('#sentence').textContent));
});

test('a refused token is said in words, and another can be given', async () => {
  await open('wrong');
  await page.locator('#token').waitFor({state: 'visible'});
  await until(() => document.querySelector('#token-words').textContent.includes('refused'));
  assert.equal(await page.textContent('#token-words'), 'The server refused the token. (unknown token)');
  await page.fill('#token-text', TOKEN);
  await page.click('#token button');
  await until(() => window.feltwire().connection === 'live' && !document.querySelector('#token').open);
});

test('without a token the page asks for one', async () => {
  await page.goto(server.url);
  await page.locator('#token').waitFor({state: 'visible'});
  assert.ok(!server.requests.includes('/live'));
});

test('the page connects again after a server stopped', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  const {port} = server;
  await server.stop();
  await until(() => window.feltwire().connection === 'waiting');
  await until(() => /does not answer.*Next attempt in \d+ s/.test(document.querySelector('#state span').textContent));
  server = await startServer({folder, port});
  const {pictures} = await state();
  await page.click('#retry', {timeout: 1000}).catch(() => {});  // It may have connected by itself.
  await until((before) => window.feltwire().connection === 'live' && window.feltwire().pictures > before + 3, pictures);
});

test('a viewer too many is told, and tries again', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  server.drop(4429, '8 viewers');
  await until(() => /as many viewers as it allows. \(8 viewers\)/.test(document.querySelector('#state span').textContent));
  await until(() => window.feltwire().connection === 'live');
});

test('another scene, a reload, and a message of the log', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  await page.selectOption('#scenes', 'other');
  await until(() => window.feltwire().scene === 'other' && window.feltwire().bodies === 1);
  assert.deepEqual(server.watched, ['other']);
  server.log('error', 'scene.json:12: "stifness" is no field');
  await page.locator('#log').waitFor({state: 'visible'});
  assert.match(await page.textContent('#log span'), /scene.json:12/);
});

test('an admin turns knobs, and is told what is refused', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  const said = () => page.textContent('#admin-said');
  const asked = (count) => until(() => true).then(async () => {
    for (let tries = 0; server.asked.length < count && tries < 600; ++tries) await page.evaluate(() => new Promise(requestAnimationFrame));
    return server.asked.at(-1);
  });
  await page.click('#admin-open');
  await page.fill('#admin input[type=password]', 'wrong');
  await page.click('#admin form button');
  await until(() => document.querySelector('#admin-said').dataset.level === 'error');
  assert.match(await said(), /not good/);
  assert.ok(!await page.getByLabel('Stiffness', {exact: true}).isVisible());  // An observer has no knobs.
  await page.fill('#admin input[type=password]', ADMIN);
  await page.click('#admin form button');
  const stiffness = page.getByLabel(/^Stiffness ?N\/m$/);
  await stiffness.waitFor({state: 'visible'});
  assert.equal(await stiffness.inputValue(), '1000');
  await stiffness.fill('250');
  await stiffness.press('Enter');
  assert.deepEqual((await asked(1)).set, {object: await page.locator('#admin select').first().inputValue(), stiffness: 250});
  await until(() => document.querySelector('#admin-said').textContent === 'changed');
  await stiffness.fill('2e9');
  await stiffness.press('Enter');
  await until(() => /at most/.test(document.querySelector('#admin-said').textContent));
  await until(() => document.querySelector('#admin input[type=number]').value === '250');
  const slider = page.locator('#admin input[type=range]');
  await slider.focus();
  await press('Home');
  assert.deepEqual((await asked(3)).set.stiffness, 10);
  await page.locator('tbody tr', {hasText: 'alice'}).click();
  await until(() => document.querySelector('#admin select[aria-label="Mode of the bound"]').disabled);
  await page.locator('tbody tr', {hasText: 'bob'}).click();
  await until(() => !document.querySelector('#admin select[aria-label="Mode of the bound"]').disabled);
  await page.selectOption('#admin select[aria-label="Mode of the bound"]', 'per_axis');
  assert.deepEqual((await asked(4)).set, {session: '4712', mode: 'per_axis'});
  await page.getByRole('button', {name: 'Evict'}).click();
  assert.deepEqual(await asked(5), {evict: '4712'});
  await page.getByRole('button', {name: /Reload/}).click();
  assert.deepEqual(await asked(6), {reload: true});
  assert.ok(server.requests.every((path) => !path.includes(ADMIN)));
});

test('an admin changes the law, the link and the lead of a client that takes them', async () => {
  await server.stop();
  server = await startServer({folder, hands: 3});
  await open();
  await until(() => window.feltwire().pictures > 3);
  const asked = async (count) => {
    for (let tries = 0; server.asked.length < count && tries < 600; ++tries) await page.evaluate(() => new Promise(requestAnimationFrame));
    return server.asked.at(-1).set;
  };
  await page.click('#admin-open');
  await page.fill('#admin input[type=password]', ADMIN);
  await page.click('#admin form button');
  await page.locator('tbody tr', {hasText: 'alice'}).click();  // It takes nothing.
  const delay = page.getByLabel(/^Delay ?ms$/);
  await until(() => document.querySelector('#admin select[aria-label="Mode of the bound"]').disabled);
  assert.ok(!await delay.isVisible());
  await page.locator('tbody tr', {hasText: 'carol'}).click();
  await until(() => !document.querySelector('#admin select[aria-label="Mode of the bound"]').disabled);
  await until(() => /has refused: mode shaped -> none/.test(document.querySelector('#admin .answer').textContent));
  await page.selectOption('#admin select[aria-label="Storage of contact_frame"]', 'elastic');
  assert.deepEqual(await asked(1), {session: '4713', storage: 'elastic'});
  await delay.fill('25');
  await delay.press('Enter');
  assert.deepEqual(await asked(2), {session: '4713', link_delay: 0.025, link_jitter: 0, link_loss: 0});
  await page.getByLabel(/^Loss ?%$/).fill('10');
  await page.getByLabel(/^Loss ?%$/).press('Enter');
  assert.deepEqual(await asked(3), {session: '4713', link_delay: 0.025, link_jitter: 0, link_loss: 0.1});
  const share = page.getByLabel(/^Share/);
  assert.equal(await share.inputValue(), '0.5');
  await share.fill('2');
  await share.press('Enter');
  assert.deepEqual(await asked(4), {session: '4713', lead_share: 2});
  await page.locator('tbody tr', {hasText: 'alice'}).click();  // She leads no robot.
  await share.waitFor({state: 'hidden'});
  if (process.env.FELTWIRE_SCREENSHOT) await page.screenshot({path: process.env.FELTWIRE_SCREENSHOT});
});

test('hostile bytes are ignored', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  const cut = server.play.picture().subarray(0, 60);
  const wild = Buffer.alloc(24);
  wild.writeUInt32LE(2, 0);
  wild.writeUInt32LE(0xffffffff, 4);
  for (const bytes of [cut, wild, Buffer.alloc(0), Buffer.from([1, 0, 0, 0]), Buffer.from([77, 1]), Buffer.from([3, 0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255])]) server.send(bytes);
  server.log('info', '<img src=x>');
  await until(() => window.feltwire().unread === 3);
  assert.equal(await page.locator('#log img').count(), 0);
  const {pictures} = await state();
  await until((before) => window.feltwire().pictures > before + 3, pictures);
});

test('keys are listed, the theme changes, and no panel leaves a phone', async () => {
  await open();
  await until(() => window.feltwire().frames > 2);
  await press('?');
  await page.locator('#help').waitFor({state: 'visible'});
  assert.ok(await page.locator('#keys dt').count() > 10);
  await press('Escape');
  const light = await pixels('view');
  assert.ok(light > 1000);
  await press('l');
  await until(() => document.documentElement.dataset.theme === 'dark');
  await page.context().close();
  page = await newPage({viewport: {width: 390, height: 800}, isMobile: true, hasTouch: true});
  await open();
  await until(() => window.feltwire().frames > 2);
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
});

test('the camera turns by keys and by mouse, and panels can be resized', async () => {
  await open();
  await until(() => window.feltwire().places.length === 2 && window.feltwire().frames > 2);
  await hold();
  const first = (await state()).places[0];
  const moved = ([x, y]) => Math.hypot(window.feltwire().places[0].x - x, window.feltwire().places[0].y - y) > 5;
  for (const key of ['ArrowLeft', 'ArrowLeft', 'ArrowLeft', 'ArrowLeft', 'ArrowUp']) await press(key);  // A hand may be near the axis.
  await until(moved, [first.x, first.y]);
  const second = (await state()).places[0];
  const name = await page.locator('#labels div', {hasText: 'bob'}).boundingBox();  // A label does not stop the drag. This one is beside the legend.
  await page.mouse.move(name.x + 5, name.y + 5);
  await page.mouse.down();
  await page.mouse.move(name.x + 65, name.y + 25, {steps: 3});
  await page.mouse.up();
  await until(moved, [second.x, second.y]);
  await press('f');
  await until(([x, y]) => Math.hypot(window.feltwire().places[0].x - x, window.feltwire().places[0].y - y) < 0.5, [first.x, first.y]);
  const width = () => page.evaluate(() => document.querySelector('#side').getBoundingClientRect().width);
  const before = await width();
  await page.focus('#split-x');
  await press('ArrowRight');
  assert.equal(await width(), before - 20);
  await page.reload();
  assert.equal(await width(), before - 20);
});

test('16 hands and 1000 bodies are shown', async () => {
  await server.stop();
  server = await startServer({folder, hands: 16, bodies: 1000});
  await open();
  await until(() => window.feltwire().bodies === 1000 && window.feltwire().frames > 5 && window.feltwire().hands.length === 16);
  await press('4');  // Its round trip is unknown.
  await until(() => window.feltwire().chosen === 4 && window.feltwire().plotted.points > 5);
  await until(() => /round trip –/.test(document.querySelector('#plots .plot:last-child .legend').textContent));
});

test('gives an address for Foxglove, and forgets it', async () => {
  await open();
  await until(() => window.feltwire().scene === 'room');
  await press('?');
  await page.click('#foxglove-open');
  await page.waitForSelector('#foxglove[open]');
  assert.equal(await page.inputValue('#foxglove input'), `ws://127.0.0.1:${server.port}/foxglove?ticket=fw_room`);
  await page.keyboard.press('Escape');
  await until(() => document.querySelector('#foxglove input').value === '');
  await press('h');  // Keys work again.
  await page.waitForSelector('#times[open]');
});

test('shows how long answers take since it was asked', async () => {
  await open();
  await until(() => window.feltwire().scene === 'room');
  await press('h');
  const rows = () => [...document.querySelectorAll('#times tr')].map((row) => [...row.cells].map((cell) => cell.textContent));
  await until(() => Number(document.querySelector('#times tr:last-child td:last-child')?.textContent) >= 20);
  const [first, second, last] = await page.evaluate(`(${rows})()`);
  assert.deepEqual([first[0], second[0], last[0]], ['≤ 10 µs', '≤ 100 µs', '> 100 µs']);
  assert.equal(second[2], '0');
  assert.equal(Number(last[2]), 4 * Number(first[2]));
  await press('Escape');
});

test('shows how late the chosen hand wakes and how long its round trips take, since it was asked', async () => {
  await open();
  await until(() => window.feltwire().scene === 'room');
  await until(() => document.querySelectorAll('#sessions tbody tr').length > 1);
  await press('h');
  const tables = () => [...document.querySelectorAll('#times h3')].filter((heading) => heading.textContent.startsWith('alice: ')).map((heading) => ({
    title: heading.textContent, rows: [...heading.nextSibling.rows].map((row) => [row.cells[0].textContent, Number(row.cells[2].textContent.replaceAll(',', ''))]),
  }));
  await until(() => [...document.querySelectorAll('#times h3')].filter((heading) => (
    heading.textContent.startsWith('alice: ') && Number(heading.nextSibling.rows[7].cells[2].textContent.replaceAll(',', '')) > 0)).length === 2);
  const [wakeups, trips] = await page.evaluate(`(${tables})()`);
  assert.equal(wakeups.title, 'alice: How late the servo woke');
  assert.deepEqual(wakeups.rows.map(([limit]) => limit), ['≤ 20 µs', '≤ 50 µs', '≤ 100 µs', '≤ 200 µs', '≤ 500 µs', '≤ 1 ms', '≤ 10 ms', '> 10 ms']);
  assert.equal(trips.title, 'alice: Round trip of a sample and its reply');
  assert.deepEqual([trips.rows[0][0], trips.rows[7][0]], ['≤ 200 µs', '> 100 ms']);
  for (const [rows, first] of [[wakeups.rows, 0], [trips.rows, 2]]) {
    assert.ok(rows[first][1] > 0);
    assert.equal(rows[7][1], 3 * rows[first][1]);  // What was counted before it was asked is left out.
    assert.equal(rows[1][1], 0);
  }
  await press('Escape');
});
