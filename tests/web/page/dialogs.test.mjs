// Windows of the live page: help, an address for Foxglove, times, and a recording that fails. Every wait is for a condition.

import assert from 'node:assert/strict';
import {test} from 'node:test';
import {newPage, open, page, press, server, until} from './page_fixture.mjs';

test('help opens at its top, every time', async () => {
  await newPage({viewport: {width: 600, height: 400}});
  await open();
  await until(() => window.feltwire().pictures > 3);
  for (let i = 0; i < 2; ++i) {
    await press('?');
    const [top, room] = await page.evaluate(() => [document.querySelector('#help').scrollTop, document.querySelector('#help').scrollHeight - document.querySelector('#help').clientHeight]);
    assert.ok(room > 100, 'it is longer than the window');
    assert.equal(top, 0);
    await page.evaluate((end) => (document.querySelector('#help').scrollTop = end), room);
    await press('Escape');
  }
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

test('a recording that cannot begin says so, and takes no ticket of others', async () => {
  await open();
  await until(() => window.feltwire().scene === 'room');
  await press('r');  // The server that is played has no Foxglove protocol.
  await until(() => /^Nothing was recorded\. It ended by itself: /.test(document.querySelector('#recorded span').textContent));
  assert.ok(server.requests.includes('/foxglove?ticket=fw_room'));
  assert.ok(await page.locator('#recorded-save').isHidden() && await page.locator('#recorded-open').isHidden());
  await page.click('#recorded-drop');
  assert.ok(await page.locator('#recorded').isHidden());
  await press('?');
  await page.click('#foxglove-open');
  await page.waitForSelector('#foxglove[open]');
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
