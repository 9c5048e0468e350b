// Recordings in a browser, made by a real client (tests/web/run-replay-tests). Every wait is for a condition.

import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {after, afterEach, before, beforeEach, test} from 'node:test';
import {join} from 'node:path';
import {pathToFileURL} from 'node:url';
import {chromium} from 'playwright-core';
import {growRecording} from './grow_recording.mjs';
import {faults, overflowing} from './judge.mjs';
import {startServer, TOKEN} from './mock_server.mjs';

const page_folder = process.env.FELTWIRE_PAGE;
const recordings = process.env.FELTWIRE_RECORDINGS;
const PATIENCE = 60_000;  // [ms] for a machine that draws in software and has more to do
const recording = (name) => ({name: `${name}.mcap`, mimeType: 'application/octet-stream', buffer: readFileSync(join(recordings, `${name}.mcap`))});
let browser;
let server;
let page;
let complaints;
let requests;

before(async () => {
  const executablePath = process.env.FELTWIRE_CHROMIUM ?? '/usr/bin/chromium';
  browser = await chromium.launch({executablePath, args: ['--no-sandbox']});
});
after(() => browser.close());

beforeEach(async () => {
  server = await startServer({folder: page_folder});
  complaints = [];
  requests = [];
  const context = await browser.newContext({viewport: {width: 1000, height: 700}, deviceScaleFactor: 0.5});
  page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  page.on('pageerror', (error) => complaints.push(error.stack));
  page.on('console', (message) => {
    if (message.type() === 'error') complaints.push(message.text());
  });
  page.on('request', (request) => {
    if (!request.url().startsWith('data:')) requests.push(request.url());
  });
});

afterEach(async () => {
  await page.context().close();
  await server.stop();
  assert.deepEqual(complaints, []);
});

const until = (condition, argument) => page.waitForFunction(condition, argument);
const state = () => page.evaluate(() => window.feltwire().replay);
const settled = (count) => until((wanted) => {
  const {stages} = window.feltwire().replay;
  return stages.length === wanted && stages.every((stage) => stage.read && stage.whole);
}, count);

/** Opens files where no server is needed, and waits until all of them is read. */
async function open(...files) {
  await page.goto(`${server.url}replay`);
  await page.setInputFiles('#recording-files', files);
  await settled(files.length);
}

/** Goes to a time by the keys, and waits until it is shown. */
async function seek(time) {
  await page.focus('#replay-bar');
  await page.keyboard.press('Home');
  for (let i = 0; i < Math.floor(time); ++i) await page.keyboard.press('ArrowRight');
  for (let i = 0; i < Math.round(100 * (time % 1)); ++i) await page.keyboard.press('ArrowUp');
  await until((wanted) => window.feltwire().replay.drawn && Math.abs(window.feltwire().replay.time - wanted) < 1e-6, time);
}

/** The rows that feltwire-lab exported, as numbers by their columns' names; `at` [s] since the first. */
function exported() {
  const [head, ...lines] = readFileSync(join(recordings, 'slide', 'hand_sample.csv'), 'utf8').trim().split('\n');
  const names = head.split(',');
  const times = lines.map((line) => BigInt(line.split(',').at(-1)));
  assert.equal(names.at(-1), 'log_time_ns');
  return lines.map((line, i) => ({...Object.fromEntries(line.split(',').map((text, k) => [names[k], Number(text)])), at: Number(times[i] - times[0]) / 1e9}));
}

/** Where the chunks lie, by the heads of all records. */
function chunksOf(buffer) {
  const chunks = [];
  for (let at = 8; at + 9 < buffer.length;) {
    const length = 9 + Number(buffer.readBigUInt64LE(at + 1));
    if (buffer[at] === 6) chunks.push({at, length});
    at += length;
  }
  return chunks;
}

const near = (shown, wanted, what) => shown.forEach((value, i) => assert.ok(Math.abs(value - wanted[i]) <= 1e-6 * Math.max(1, Math.abs(wanted[i])), `${what}: ${shown} is not ${wanted}`));

test('a recording is shown as the laboratory reads it, and nothing is asked of the server', async () => {
  await open(recording('slide'));
  assert.ok(!(await page.locator('#token').isVisible()));
  const before = requests.length;
  const rows = exported();
  for (const time of [0.5, 1.25, 3.1, 4.73]) {
    await seek(time);
    const {first} = (await state()).stages[0];
    const row = rows.findLast(({at}) => at <= time + 1e-9);
    near(first.position, [row.x, row.y, row.z], `position at ${time}`);
    near(first.elastic, [row.ex, row.ey, row.ez], `elastic force at ${time}`);
    near(first.friction, [row.fx, row.fy, row.fz], `friction at ${time}`);
    near(first.held, [row.rx, row.ry, row.rz], `held force at ${time}`);
  }
  assert.equal(requests.length, before);
  assert.ok(!server.requests.includes('/live'));
  assert.deepEqual((await state()).stages[0].troubles, []);
});

test('the hand moves, arrows and plots are there, and the reason is said', async () => {
  await open(recording('slide'));
  await seek(2);
  const [first] = (await state()).stages;
  await seek(2.6);
  const [second] = (await state()).stages;
  assert.ok(Math.hypot(...first.first.position.map((x, i) => x - second.first.position[i])) > 1e-3);
  assert.ok(second.longestArrow > 1e-3);
  assert.ok(second.points.every((points) => points > 100), `${second.points}`);
  assert.match(await page.textContent('[data-part="sentence"]'), /The scene asks for .* N, and the device renders .* N/);
  assert.match(await page.textContent('[data-part="reason"]'), /^felt: /);
  await seek(0);
  assert.match(await page.textContent('[data-part="reason"]'), /^(no_reply|touches_nothing|ramp|felt): /);
});

test('it plays, repeats and stops at the end', async () => {
  await open(recording('taps'));
  await page.selectOption('#replay-speed', '10');
  await page.keyboard.press(' ');
  await until(() => window.feltwire().replay.playing === false && window.feltwire().replay.time === window.feltwire().replay.to);
  await page.check('#replay-loop');
  await page.focus('#replay-bar');
  await page.keyboard.press(' ');
  await until(() => window.feltwire().replay.time < 0.5 * window.feltwire().replay.to);
  assert.ok((await state()).playing);
  await page.click('#replay-play');
  assert.ok(!(await state()).playing);
});

test('the pointer seeks on the bar and in the plots', async () => {
  await open(recording('taps'));
  const bar = await page.locator('#replay-bar').boundingBox();
  await page.mouse.click(bar.x + bar.width / 2, bar.y + 10);
  await until(() => window.feltwire().replay.drawn && window.feltwire().replay.time > 0.4 * window.feltwire().replay.to);  // a plot is clicked where it was drawn
  const {time, to} = await state();
  assert.ok(Math.abs(time - to / 2) < 0.02 * to, `${time} of ${to}`);
  const plot = await page.locator('.stage .u-over').first().boundingBox();
  await page.mouse.click(plot.x + 0.75 * plot.width, plot.y + 0.5 * plot.height);
  const later = (await state()).time;
  assert.ok(Math.abs(later - time - 0.25 * 5) < 0.05, `${later} after ${time}`);
});

/** Presses a button of the recording. @returns {Promise<Buffer>} the file that the browser saves */
async function saved(part) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click(`.stage [data-part="${part}"]`)]);
  return readFileSync(await download.path());
}

test('plots of a recording zoom, move, say the values under the pointer, and are saved', async () => {
  await open(recording('slide'));
  await seek(3);
  const {x, y, width, height} = await page.locator('.stage .u-over').first().boundingBox();
  await page.mouse.move(x + 0.25 * width, y + 0.5 * height);
  await page.mouse.wheel(0, -400);
  await until(() => window.feltwire().replay.drawn && window.feltwire().replay.stages[0].range[1] - window.feltwire().replay.stages[0].range[0] < 2.5);
  const {stages: [{range: [from, to]}], time} = await state();
  assert.ok(Math.abs((from + to) / 2 - time) < 1e-9 && time === 3);
  await page.mouse.move(x + 0.26 * width, y + 0.5 * height);
  await until(() => /^at 0:0\d\.\d{3}$/.test(document.querySelector('.stage [data-part="plot-time"]').textContent));
  const under = from + 0.26 * (to - from);
  const said = Number(/\d\.\d{3}$/.exec(await page.textContent('.stage [data-part="plot-time"]'))[0]);
  assert.ok(Math.abs(said - under) < 0.02, `${said} s, not ${under}`);
  const rows = exported();
  const row = rows.findLast(({at}) => at <= said + 1e-3);
  const held = Number(/held ([\d.]+) N/.exec(await page.textContent('.stage .legend'))[1]);
  assert.ok(Math.abs(held - Math.hypot(row.rx, row.ry, row.rz)) < 0.1, `${held} N at ${said} s`);

  const [head, ...lines] = (await saved('csv')).toString().trim().split('\n');
  assert.equal(head, 'time_s,elastic_N,friction_N,commanded_N,held_N,balance_J,cut_percent,reply_age_ms');
  const wanted = rows.filter(({at}) => at > from && at <= to);
  assert.ok(Math.abs(lines.length - wanted.length) <= 2, `${lines.length} rows, not ${wanted.length}`);
  const [second, elastic] = lines[10].split(',').map(Number);
  const same = rows.find(({at}) => Math.abs(at - second) < 1e-6);
  assert.ok(Math.abs(elastic - Math.hypot(same.ex, same.ey, same.ez)) < 1e-5 * Math.max(elastic, 1), lines[10]);
  assert.deepEqual([...(await saved('png')).subarray(0, 4)], [0x89, 0x50, 0x4e, 0x47]);

  await page.mouse.move(x + 0.5 * width, y + 0.5 * height);
  await page.mouse.down();
  for (let i = 1; i <= 10; ++i) await page.mouse.move(x + (0.5 - 0.02 * i) * width, y + 0.5 * height);
  await page.mouse.up();
  const moved = (await state()).time - 3;
  assert.ok(moved > 0.1 * (to - from) && moved < 0.25 * (to - from), `${moved} s later`);
});

test('an observer\'s recording has the hands of the scene', async () => {
  await open(recording('seen'));
  await seek(2.5);
  const [stage] = (await state()).stages;
  assert.equal(stage.shown.length, 1);
  assert.ok(stage.shown[0] > 0);
  assert.ok(Math.hypot(...stage.first.held) > 0.01);
});

test('a recording of a server begins where a hand is, and lists what happened', async () => {
  await open(recording('room'));
  await until(() => window.feltwire().replay.drawn && window.feltwire().replay.time > 0);
  const {time, stages: [stage]} = await state();
  assert.ok(time > 0.9, `${time} s: an observer was there alone before`);
  assert.ok(stage.first);
  const texts = stage.marks.map(({text}) => text);
  for (const session of [1, 2, 3, 4]) for (const how of ['begins', 'ends']) assert.ok(texts.includes(`session ${session} ${how}`), `session ${session} ${how}: ${texts}`);
  assert.deepEqual(texts.slice(0, 2), ['session 1 begins', 'session 1 ends']);
  assert.ok(stage.marks.every((mark, i) => i === 0 || mark.time >= stage.marks[i - 1].time));
  const last = stage.marks.at(-1);
  await page.selectOption('.stage [data-part="marks"]', {index: stage.marks.length});
  await until((wanted) => window.feltwire().replay.drawn && window.feltwire().replay.time === wanted, last.time);
  await page.focus('#replay-bar');
  await page.keyboard.press(',');
  await until((wanted) => window.feltwire().replay.time === wanted, stage.marks.findLast((mark) => mark.time < last.time - 1e-6).time);
});

/** A recording with metadata as a program writes them with fw_recorder_mark(). */
async function withMarks(name, marks) {
  const [{McapFile}, {McapWriter}] = await Promise.all(['replay/mcap.js', 'mcap_writer.js'].map((script) => import(`../page/src/${script}`)));
  const mcap = await McapFile.open(new File([readFileSync(join(recordings, `${name}.mcap`))], name));
  const writer = new McapWriter('test');
  const ids = new Map([...mcap.channels].map(([id, topic]) => [id, writer.addChannel(0, topic, 'protobuf')]));
  for (const [text, seconds] of marks) writer.addMetadata('mark', {text, time: seconds === null ? 'now' : String(mcap.chunks[0].from + BigInt(1e9 * seconds))});
  for (const chunk of mcap.chunks) {
    const records = Buffer.from(await mcap.read(chunk));
    for (let at = 0; at < records.length; at += 9 + Number(records.readBigUInt64LE(at + 1))) {
      if (records[at] !== 5) continue;
      writer.write(ids.get(records.readUInt16LE(at + 9)), records.readBigUInt64LE(at + 15), records.subarray(at + 31, at + 9 + Number(records.readBigUInt64LE(at + 1))));
    }
  }
  return Buffer.concat(writer.finish());
}

test('moments that a program marked are listed, by the index and without it', async () => {
  const whole = await withMarks('taps', [['grasped', 1.5], ['no time', null], ['let go', 0.5]]);
  for (const [name, buffer] of [['whole.mcap', whole], ['cut.mcap', whole.subarray(0, whole.length - 20)]]) {
    await open({name, mimeType: '', buffer});
    assert.deepEqual((await state()).stages[0].marks, [{time: 0.5, text: 'let go'}, {time: 1.5, text: 'grasped'}], name);
    assert.deepEqual(await page.locator('.stage [data-part="marks"] option').allTextContents(), ['2 marks', '0:00.500 let go', '0:01.500 grasped']);
  }
});

test('a page with a recording on it: nothing is too wide, contrast is 4.5 or more, and all controls have names', async () => {
  for (const [width, colorScheme] of [[360, 'light'], [768, 'light'], [1360, 'light'], [1360, 'dark'], [1920, 'light']]) {
    await page.setViewportSize({width, height: width === 360 ? 2400 : 860});  // The bar stays at the lower end of a phone's window, over what is scrolled.
    await page.emulateMedia({colorScheme});
    await open(recording('room'));
    await until(() => window.feltwire().replay.drawn && window.feltwire().replay.time > 0);
    assert.deepEqual(await overflowing(page), [], `${width} px`);
    if (width !== 768 && width !== 1920) assert.deepEqual(await faults(page), [], `${width} px, ${colorScheme}`);
  }
  await open(recording('slide'), recording('taps'));
  assert.deepEqual(await overflowing(page), [], 'two');
  assert.deepEqual(await faults(page), [], 'two');
});

test('a cut file is shown up to where it was cut', async () => {
  const whole = recording('slide');
  const cut = {...whole, name: 'cut.mcap', buffer: whole.buffer.subarray(0, Math.floor(0.6 * whole.buffer.length))};
  await open(cut);
  const [stage] = (await state()).stages;
  const duration = exported().at(-1).at;
  assert.ok(stage.duration > 0.3 * duration && stage.duration < 0.8 * duration, `${stage.duration} of ${duration}`);
  assert.match(stage.troubles.join(), /cut\.mcap: it has no end: it was cut at byte \d+/);
  await seek(1);
  assert.ok((await state()).stages[0].first);
});

test('damage is said with its place and what to do, and the rest is shown', async () => {
  const {buffer} = recording('slide');
  const chunk = chunksOf(buffer)[2];
  const damaged = Buffer.from(buffer);
  damaged[chunk.at + Math.floor(chunk.length / 2)] ^= 0x10;
  await open({name: 'damaged.mcap', mimeType: '', buffer: damaged});
  const [stage] = (await state()).stages;
  assert.equal(stage.troubles.length, 1);
  assert.match(stage.troubles[0], /^damaged\.mcap: byte \d+: .*; the file is damaged: copy it anew from where it was recorded$/);
  assert.ok(stage.troubles[0].includes(`byte ${chunk.at}: `));
  await seek(5);
  assert.ok((await state()).stages[0].first);
  assert.match(await page.textContent('[data-part="trouble"]'), /copy it anew/);
});

test('a wrong CRC is damage', async () => {
  const {buffer} = recording('slide');
  const chunk = chunksOf(buffer)[1];
  const damaged = Buffer.from(buffer);
  damaged[chunk.at + 9 + 24] ^= 1;  // After opcode, length, two times and a size.
  await open({name: 'crc.mcap', mimeType: '', buffer: damaged});
  assert.deepEqual((await state()).stages[0].troubles, [
    `crc.mcap: byte ${chunk.at}: the CRC of a chunk is wrong; the file is damaged: copy it anew from where it was recorded`]);
});

test('a damaged index is said, and the file is searched without it', async () => {
  const {buffer} = recording('slide');
  const damaged = Buffer.from(buffer);
  damaged[buffer.length - 60] ^= 1;
  await open({name: 'index.mcap', mimeType: '', buffer: damaged});
  const [stage] = (await state()).stages;
  assert.match(stage.troubles[0], /the CRC of the summary is wrong/);
  assert.ok(Math.abs(stage.duration - exported().at(-1).at) < 1e-3);
});

test('what is no recording is refused in words', async () => {
  await page.goto(`${server.url}replay`);
  for (const [name, buffer, said] of [
    ['text.mcap', Buffer.from('t,x,y,z\n'), /text\.mcap: byte 0: this is no MCAP file; choose one that --record FILE\.mcap wrote/],
    ['empty.mcap', Buffer.alloc(0), /empty\.mcap: byte 0: this is no MCAP file/],
    ['begin.mcap', recording('taps').buffer.subarray(0, 600), /begin\.mcap: byte \d+: there is no message in it; record for longer/],
  ]) {
    await page.setInputFiles('#recording-files', {name, mimeType: '', buffer});
    await until((pattern) => new RegExp(pattern).test(document.querySelector('#log span').textContent), said.source);
  }
  assert.equal((await state()).stages.length, 0);
});

test('every byte may be wrong: the page never fails', async () => {
  const {buffer} = recording('taps');
  await page.goto(`${server.url}replay`);
  for (let i = 0; i < 12; ++i) {
    const wild = Buffer.from(buffer);
    for (let k = 0; k < 40; ++k) wild[(7919 * (k + 41 * i) + 13 * k * k) % wild.length] ^= 1 << (k % 8);
    await page.setInputFiles('#recording-files', {name: `wild${i}.mcap`, mimeType: '', buffer: wild});
    await until((name) => {
      const {stages} = window.feltwire().replay;
      return document.querySelector('#log span').textContent.includes(name) || stages.some((stage) => stage.name === name && stage.read);
    }, `wild${i}.mcap`);
  }
  await page.setInputFiles('#recording-files', recording('taps'));
  await until(() => window.feltwire().replay.stages.some((stage) => stage.name === 'taps.mcap' && stage.read && stage.troubles.length === 0));
});

test('two recordings share the bar, side by side', async () => {
  await open(recording('slide'), recording('taps'));
  await seek(2);
  const both = (await state()).stages;
  const [left, right] = await Promise.all([0, 1].map((i) => page.locator('.stage').nth(i).boundingBox()));
  assert.ok(right.x >= left.x + left.width - 1 && Math.abs(right.y - left.y) < 1);
  assert.ok(both.every(({first}) => first));
  await page.fill('#replay-offset', '3');
  await until(() => window.feltwire().replay.to > 6.5 && window.feltwire().replay.drawn);
  const [, second] = (await state()).stages;
  assert.equal(second.first, null);  // It has not begun at 2 s.
  await seek(5);  // The second is now where it was at 2 s before.
  near((await state()).stages[1].first.position, both[1].first.position, 'the second');
  await page.click('#replay-clock');
  const {offset} = (await state()).stages[1];
  assert.ok(offset > 3, `the second was recorded ${offset} s after the first`);  // One after the other.
  await page.locator('[data-part="close"]').first().click();
  await until(() => window.feltwire().replay.stages.length === 1 && window.feltwire().replay.stages[0].name === 'taps.mcap');
  assert.equal((await state()).stages[0].offset, 0);
});

test('of a large file only the parts that are shown are read at first', async () => {
  const path = join(recordings, 'long.mcap');
  await growRecording(join(recordings, 'slide.mcap'), path, 48);
  await page.addInitScript(() => {
    const {slice} = Blob.prototype;
    window.bytesRead = 0;
    Blob.prototype.slice = function counted(from, to) {
      const part = slice.call(this, from, to);
      window.bytesRead += part.size;
      return part;
    };
    new MutationObserver((changes, watcher) => {  // The first words on the hand.
      if (!/The scene asks|It moves freely/.test(document.querySelector('[data-part="sentence"]')?.textContent)) return;
      window.bytesAtFirst = window.bytesRead;
      watcher.disconnect();
    }).observe(document, {subtree: true, childList: true, characterData: true});
  });
  await page.goto(`${server.url}replay`);
  await page.setInputFiles('#recording-files', path);
  await until(() => window.bytesAtFirst > 0);
  const first = await page.evaluate(() => window.bytesAtFirst);
  assert.ok(first < 8 * 2 ** 20, `${first} bytes`);
  await settled(1);  // All of it, in the end.
  assert.ok(await page.evaluate(() => window.bytesRead) > 48 * 2 ** 20);
  const {duration, kept} = (await state()).stages[0];
  assert.ok(duration > 60 && kept <= 96 * 2 ** 20, `${duration} s, ${kept} bytes`);
  await page.keyboard.press('End');
  await until(() => window.feltwire().replay.stages[0].whole && window.feltwire().replay.time > 60);
});

test('a file that is dropped on the live page ends it', async () => {
  await page.goto(`${server.url}#token=${TOKEN}`);
  await until(() => window.feltwire().pictures > 3);
  const content = recording('taps').buffer.toString('base64');
  await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
    const transfer = new DataTransfer();
    transfer.items.add(new File([bytes], 'dropped.mcap'));
    dispatchEvent(new DragEvent('drop', {dataTransfer: transfer}));
  }, content);
  await settled(1);
  assert.equal((await state()).stages[0].name, 'dropped.mcap');
  assert.ok(!(await page.locator('#panels').isVisible()));
  assert.equal(await page.evaluate(() => window.feltwire().connection), 'ended');
  await page.click('#live-page');
  await until(() => window.feltwire?.().pictures > 3 && !window.feltwire().replay.active);  // The page is asked for anew.
});

test('the page as one file needs no server and may reach none', async () => {
  await page.goto(pathToFileURL(join(page_folder, 'feltwire-replay.html')).href);
  await page.setInputFiles('#recording-files', recording('taps'));
  await settled(1);
  assert.equal(requests.length, 1);
  const refused = await page.evaluate((url) => fetch(url).then(() => false, () => true), server.url);
  assert.ok(refused);
  assert.ok(complaints.splice(0).every((text) => /Content Security Policy/.test(text)));
});
