// Recordings at the server: what an admin sees of them, starts, stops and saves. Every wait is for a condition.

import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {test} from 'node:test';
import {ADMIN, RECORDING} from './mock_server.mjs';
import {newServer, open, page, server, until} from './page_fixture.mjs';

const state = () => document.querySelector('#server-record-state').textContent;
const unlock = async () => {
  await page.fill('#admin input[type=password]', ADMIN);
  await page.click('#admin form button');
};

test('an admin records at the server, is told how long and why it ended, and saves the file', async () => {
  await newServer({file: Buffer.from('a whole recording')});
  await open();
  await until(() => window.feltwire().scene === 'room');
  await page.click('#admin-open');
  await page.click('#admin-scene-tab');
  const button = page.locator('#server-record');
  assert.ok(await button.isHidden());  // A viewer that is no admin sees nothing of it.
  await unlock();
  await button.waitFor();
  assert.equal(await button.textContent(), 'Record at the server');
  await button.click();
  await until(() => /^Records since \d+ s, 1\.2 MB\.$/.test(document.querySelector('#server-record-state').textContent));
  assert.equal(await button.getAttribute('aria-pressed'), 'true');
  assert.equal(await page.locator('#admin .recordings li').count(), 0);  // It is not complete yet.

  server.endRecording('room');
  await until(() => document.querySelector('#server-record').ariaPressed === 'false');
  assert.equal(await page.evaluate(state), 'It ended after 3 s, 1.2 MB: the server’s disk has too little room.');
  await button.click();
  await until(() => document.querySelector('#server-record').ariaPressed === 'true');
  await button.click();
  await page.locator('#admin .recordings li').waitFor();
  assert.match(await page.textContent('#admin .recordings li span'), new RegExp(`^${RECORDING} \\d\\.\\d MB$`));
  assert.equal(await page.evaluate(state), '');
  const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', {name: `Save ${RECORDING}`}).click()]);
  assert.equal(download.suggestedFilename(), RECORDING);
  assert.equal(readFileSync(await download.path(), 'utf8'), 'a whole recording');
  assert.ok(server.requests.every((path) => !path.includes(ADMIN)));
});

test('a recording that another admin has started is seen to run, and what is refused is said', async () => {
  await open();
  await until(() => window.feltwire().scene === 'room');
  await page.click('#admin-open');
  await page.click('#admin-scene-tab');
  await unlock();
  await page.locator('#server-record').waitFor();
  server.startRecording();
  await page.click('#server-record');  // The page does not know yet that it runs.
  await until(() => /runs already/.test(document.querySelector('#admin-said').textContent));
  await until(() => document.querySelector('#server-record').textContent === 'Stop the recording');
});
