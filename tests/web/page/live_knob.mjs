// A knob of a real server's page changes what a hand feels: node live_knob.mjs LINK_WITH_THE_TOKEN_OF_AN_ADMIN
// A simulated hand slides on the table of scenes/room.json (900 N/m). What is asked for per depth is its stiffness.

import assert from 'node:assert/strict';
import {chromium} from 'playwright-core';

const PATIENCE = 60_000;  // [ms] for a machine that draws in software and has more to do
const executablePath = process.env.FELTWIRE_CHROMIUM ?? '/usr/bin/chromium';
const browser = await chromium.launch({executablePath, args: ['--no-sandbox']});
try {
  const page = await browser.newPage();
  page.setDefaultTimeout(PATIENCE);
  const complaints = [];
  page.on('pageerror', (error) => complaints.push(error.stack));
  page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));

  /** Waits until the plots show this stiffness [N/m]: newtons per millimetre. */
  const feels = (stiffness) => page.waitForFunction((wanted) => {
    const [[elastic], [depth]] = window.feltwire?.().plotted.last.map((pane) => pane ?? []) ?? [[], []];
    return depth > 0.1 && Math.abs((1000 * elastic) / depth / wanted - 1) < 0.02;
  }, stiffness);

  await page.goto(process.argv[2]);
  await feels(900);
  await page.click('#admin-open');
  await page.locator('#admin select').first().selectOption('table');
  const stiffness = page.getByLabel(/^Stiffness ?N\/m$/);
  assert.equal(await stiffness.inputValue(), '900');
  await stiffness.fill('300');
  await stiffness.press('Enter');
  await page.waitForFunction(() => /stiffness 900 -> 300/.test(document.querySelector('#admin-said').textContent));
  await feels(300);
  await stiffness.fill('-5');
  await stiffness.press('Enter');
  await page.waitForFunction(() => /stiffness: must be above zero/.test(document.querySelector('#admin-said').textContent));
  await page.waitForFunction(() => document.querySelector('#admin input[type=number]').value === '300');
  await page.click('#admin-scene-tab');
  await page.getByRole('button', {name: /Reload/}).click();
  await page.waitForFunction(() => /was reloaded/.test(document.querySelector('#log span').textContent));
  await feels(900);  // what the file says
  assert.deepEqual(complaints, []);
} finally {
  await browser.close();
}
