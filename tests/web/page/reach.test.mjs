// Everyone reaches all of the live page: at every width, in every language, in both themes, and with a screen reader. axe-core judges contrast and names.

import assert from 'node:assert/strict';
import {join} from 'node:path';
import {test} from 'node:test';
import {faults, overflowing} from './judge.mjs';
import {ADMIN} from './mock_server.mjs';
import {hold, newPage, newServer, open, page, press, state, until} from './page_fixture.mjs';

const WIDTHS = [360, 768, 1360, 1920];  // [px]
const LOCALES = ['en-US', 'de-DE', 'ko-KR'];

/** Opens the page with eight hands in a window of this width. @param {'light' | 'dark'} colorScheme @param {string} locale of the browser */
async function show(width, colorScheme, locale = 'en-US') {
  const phone = width < 500;
  await newPage({viewport: {width, height: phone ? 800 : 860}, colorScheme, locale, isMobile: phone, hasTouch: phone, deviceScaleFactor: 1});
  await open();
  await until(() => window.feltwire().pictures > 3 && window.feltwire().frames > 2 && document.querySelectorAll('tbody tr').length === 8);
  await until(() => [...document.querySelectorAll('#reasons li')].some((item) => !item.hidden));
}

/** Keeps a picture of the page for people, where FELTWIRE_SCREENSHOTS names a folder. */
async function keep(name) {
  const pictures = process.env.FELTWIRE_SCREENSHOTS;
  if (pictures) await page.screenshot({path: join(pictures, `${name}.png`)});
}

const showRecorded = (hidden) => page.evaluate((wanted) => (document.querySelector('#recorded').hidden = wanted), hidden);

/** What can be opened over the scene: a name, how it opens, and how it closes. */
const PARTS = [
  ['help', '#help', () => press('?'), () => press('Escape')],
  ['times', '#times table', () => press('h'), () => press('Escape')],
  ['admin', '#admin', () => page.click('#admin-open'), () => page.click('#admin-open')],
  ['tour', '#tour', () => press('w'), () => press('w')],
  ['a recording', '#recorded', () => showRecorded(false), () => showRecorded(true)],
];

for (const [width, locale] of WIDTHS.flatMap((width) => LOCALES.map((locale) => [width, locale]))) {
  test(`nothing is wider than a window of ${width} px, ${locale}`, async () => {
    await newServer({hands: 8});
    await show(width, 'light', locale);
    assert.equal(await page.evaluate(() => document.documentElement.lang), locale.slice(0, 2));
    assert.deepEqual(await overflowing(page), []);
    if (locale === 'en-US') {
      await keep(`${width}-light`);
      await press('l');
      await until(() => document.documentElement.dataset.theme === 'dark');
      await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
      await keep(`${width}-dark`);
      await press('l');
    }
    for (const [part, selector, begin, end] of PARTS) {
      await begin();
      await page.locator(selector).first().waitFor({state: 'visible'});
      assert.deepEqual(await overflowing(page), [], part);
      if (locale === 'en-US') await keep(`${width}-${part.replace(' ', '-')}`);
      await end();
    }
  });
}

for (const [width, theme] of [[360, 'light'], [1360, 'light'], [1360, 'dark']]) {
  test(`at ${width} px, ${theme}: contrast is 4.5 or more, and all controls have names`, async () => {
    await newServer({hands: 8});
    await show(width, theme);
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), theme);
    await hold();  // Names stand still.
    assert.deepEqual(await faults(page), []);
    for (const [part, selector, begin, end] of PARTS) {
      await begin();
      await page.locator(selector).first().waitFor({state: 'visible'});
      assert.deepEqual(await faults(page), [], part);
      await end();
    }
    await page.click('#admin-open');
    await page.fill('#admin input[type=password]', ADMIN);
    await page.click('#admin form button');
    await until(() => !document.querySelector('#admin fieldset').disabled);
    assert.deepEqual(await faults(page), [], 'admin, unlocked');
    await page.click('#admin-open');
    await page.evaluate(() => document.querySelector('#foxglove').showModal());
    assert.deepEqual(await faults(page), [], 'foxglove');
  });
}

test('Tab goes to every control in the order of the page, each is seen to have the focus, and it ends', async () => {
  await newServer({hands: 8});
  await show(1360, 'light');
  await press(' ');  // Rows stay where they are.
  const wanted = await page.evaluate(() => {
    const all = document.querySelectorAll('a[href], button, input, select, summary, [tabindex="0"]');
    const found = [...all].filter((item) => item.checkVisibility({visibilityProperty: true}) && !item.matches(':disabled, [tabindex="-1"]') && !item.closest('dialog'));
    found.forEach((item, i) => (item.dataset.stop = i));
    document.activeElement.blur();
    return found.map((item) => item.id || item.textContent.slice(0, 20) || item.tagName);
  });
  assert.ok(wanted.length > 40, `${wanted.length} controls`);
  const reached = [];
  for (let i = 0; i < 2 * wanted.length; ++i) {
    await press('Tab');
    const stop = await page.evaluate(() => {
      const {activeElement: item} = document;
      const {outlineStyle, outlineWidth} = getComputedStyle(item);
      return {body: item === document.body, stop: item.dataset.stop, seen: outlineStyle !== 'none' && parseFloat(outlineWidth) > 0};
    });
    if (stop.body || Number(stop.stop) === reached[0]) break;  // It left the page, or began anew: it is in no trap.
    if (stop.stop === undefined) continue;  // Something that scrolls.
    reached.push(Number(stop.stop));
    assert.ok(stop.seen, `${wanted[Number(stop.stop)]} is not seen to have the focus`);
  }
  assert.deepEqual(reached, wanted.map((_, i) => i), `not reached in order: ${wanted.filter((_, i) => !reached.includes(i)).join()}`);
});

test('the page that asks for a token, and the page of recordings, are read as well', async () => {
  for (const colorScheme of ['light', 'dark']) {
    await newPage({viewport: {width: 1360, height: 860}, colorScheme});
    await open('wrong');
    await page.locator('#token').waitFor({state: 'visible'});
    assert.deepEqual(await faults(page), [], `token, ${colorScheme}`);
    await page.goto(new URL('replay', page.url()).href);
    await page.locator('#replay-empty').waitFor({state: 'visible'});
    assert.deepEqual(await faults(page), [], `recordings, ${colorScheme}`);
    assert.deepEqual(await overflowing(page), [], 'recordings');
  }
  assert.equal((await state()).held, false);
});
