// Everyone reaches all of the live page: at every width, in every language, in both themes, and with a screen reader. axe-core judges contrast and names.

import assert from 'node:assert/strict';
import {test} from 'node:test';
import axe from 'axe-core';
import {ADMIN} from './mock_server.mjs';
import {newPage, newServer, open, page, press, state, until} from './page_fixture.mjs';

const WIDTHS = [360, 768, 1360, 1920];  // [px]
const LOCALES = ['en-US', 'de-DE', 'ko-KR'];
const TAGS = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'];

/** Opens the page with eight hands in a window of this width. @param {'light' | 'dark'} colorScheme @param {string} locale of the browser */
async function show(width, colorScheme, locale = 'en-US') {
  const phone = width < 500;
  await newPage({viewport: {width, height: phone ? 800 : 860}, colorScheme, locale, isMobile: phone, hasTouch: phone, deviceScaleFactor: 1});
  await open();
  await until(() => window.feltwire().pictures > 3 && window.feltwire().frames > 2 && document.querySelectorAll('tbody tr').length === 8);
  await until(() => [...document.querySelectorAll('#reasons li')].some((item) => !item.hidden));
}

/** @returns {Promise<string[]>} elements whose content is wider than they are, unless it ends in an ellipsis */
const overflowing = () => page.evaluate(() => {
  const name = (element) => element.tagName.toLowerCase() + (element.id ? `#${element.id}` : '') + (element.className ? `.${element.className}` : '');
  const found = document.documentElement.scrollWidth > innerWidth ? [`the page: ${document.documentElement.scrollWidth} of ${innerWidth} px`] : [];
  for (const element of document.body.querySelectorAll('*')) {
    if (!element.checkVisibility() || element.closest('#labels, .drawing, .arrow') || getComputedStyle(element.parentElement).textOverflow === 'ellipsis') continue;  // Their content is drawn, and may end at the edge.
    const style = getComputedStyle(element);
    const {left, right} = element.getBoundingClientRect();
    if (left < -1 || right > innerWidth + 1) found.push(`${name(element)}: from ${Math.round(left)} to ${Math.round(right)} px`);
    const wide = element.clientWidth > 0 && element.scrollWidth > element.clientWidth + 1;
    if (wide && style.textOverflow !== 'ellipsis' && style.display !== 'inline') found.push(`${name(element)}: ${element.scrollWidth} of ${element.clientWidth} px`);
  }
  return found;
});

/** @returns {Promise<string[]>} all that axe-core finds wrong, and each text whose contrast it cannot tell, but for
 *   texts of a letter or a sign */
async function faults() {
  await page.evaluate(() => scrollTo(0, 0));  // Else the header lies over what was scrolled below it.
  await page.evaluate(axe.source);
  return page.evaluate(async (tags) => {
    const {violations, incomplete} = await window.axe.run(document.querySelector('dialog[open]') ?? document, {runOnly: tags, resultTypes: ['violations', 'incomplete']});
    const judged = ({any}) => !['shortTextContent', 'nonBmp'].includes(any[0]?.data?.messageKey);
    const unknown = incomplete.filter(({id}) => id === 'color-contrast').map(({id, nodes}) => ({id, nodes: nodes.filter(judged)}));
    return [...violations, ...unknown].flatMap(({id, nodes}) => nodes.map(({target, any, all, none}) => (
      `${id} ${target.join(' ')}: ${[...any, ...all, ...none][0]?.message ?? ''}`)));
  }, TAGS);
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
    assert.deepEqual(await overflowing(), []);
    for (const [part, selector, begin, end] of PARTS) {
      await begin();
      await page.locator(selector).first().waitFor({state: 'visible'});
      assert.deepEqual(await overflowing(), [], part);
      await end();
    }
  });
}

for (const [width, theme] of [[360, 'light'], [1360, 'light'], [1360, 'dark']]) {
  test(`at ${width} px, ${theme}: contrast is 4.5 or more, and all controls have names`, async () => {
    await newServer({hands: 8});
    await show(width, theme);
    assert.equal(await page.evaluate(() => document.documentElement.dataset.theme), theme);
    await press(' ');  // Names stand still.
    assert.deepEqual(await faults(), []);
    for (const [part, selector, begin, end] of PARTS) {
      await begin();
      await page.locator(selector).first().waitFor({state: 'visible'});
      assert.deepEqual(await faults(), [], part);
      await end();
    }
    await page.click('#admin-open');
    await page.fill('#admin input[type=password]', ADMIN);
    await page.click('#admin form button');
    await until(() => !document.querySelector('#admin fieldset').disabled);
    assert.deepEqual(await faults(), [], 'admin, unlocked');
    await page.click('#admin-open');
    await page.evaluate(() => document.querySelector('#foxglove').showModal());
    assert.deepEqual(await faults(), [], 'foxglove');
  });
}

test('the page that asks for a token, and the page of recordings, are read as well', async () => {
  for (const colorScheme of ['light', 'dark']) {
    await newPage({viewport: {width: 1360, height: 860}, colorScheme});
    await open('wrong');
    await page.locator('#token').waitFor({state: 'visible'});
    assert.deepEqual(await faults(), [], `token, ${colorScheme}`);
    await page.goto(new URL('replay', page.url()).href);
    await page.locator('#replay-empty').waitFor({state: 'visible'});
    assert.deepEqual(await faults(), [], `recordings, ${colorScheme}`);
    assert.deepEqual(await overflowing(), [], 'recordings');
  }
  assert.equal((await state()).held, false);
});
