// The page speaks the browser's language, or the one that the user chose. FELTWIRE_PAGE_SOURCE: the folder of the page's sources.

import assert from 'node:assert/strict';
import {join} from 'node:path';
import {test} from 'node:test';
import {pathToFileURL} from 'node:url';
import {newPage, open, page, press, until} from './page_fixture.mjs';

const {TEXTS} = await import(pathToFileURL(join(process.env.FELTWIRE_PAGE_SOURCE, 'src/texts.js')));

async function show(locale) {
  await newPage({viewport: {width: 1360, height: 860}, locale});
  await open();
  await until(() => window.feltwire().frames > 3 && document.querySelectorAll('#sessions tbody tr').length === 2);
}
const language = () => page.evaluate(() => document.documentElement.lang);

/** All texts of the page, of what is hidden too: what is between tags, and what screen readers and pointers are told. */
const texts = () => page.evaluate(() => {
  const found = new Set();
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_ALL);
  for (let node = walk.nextNode(); node; node = walk.nextNode()) {
    if (node.nodeType === Node.TEXT_NODE && !node.parentElement.closest('script, style')) found.add(node.textContent.trim());
    if (node.nodeType === Node.ELEMENT_NODE) for (const name of ['title', 'aria-label', 'placeholder']) if (node.getAttribute(name)) found.add(node.getAttribute(name).trim());
  }
  return [...found];
});

test('the browser chooses the language, and English stands for those that are not there', async () => {
  for (const [locale, tag, key] of [['de-CH', 'de', 1], ['ko-KR', 'ko', 2], ['fr-FR', 'en', 0]]) {
    await show(locale);
    assert.equal(await language(), tag);
    assert.equal(await page.evaluate(() => document.querySelector('#see-all').firstChild.textContent), TEXTS['bar.all'][key]);
  }
});

test('the choice of the user is remembered, and numbers stay as they are', async () => {
  await show('en-US');
  const value = () => page.evaluate(() => document.querySelector('#arrow-scale').textContent);
  assert.match(await value(), /^1 N = [\d.]+ (mm|cm)$/);
  await page.selectOption('#language', 'de');
  await until(() => document.documentElement.lang === 'de' && window.feltwire?.().frames > 3);
  assert.equal(await page.evaluate(() => document.querySelector('#hold').firstChild.textContent), TEXTS['head.hold'][1]);
  assert.match(await value(), /^1 N = [\d.]+ (mm|cm)$/);
  await page.reload();
  await until(() => window.feltwire?.().frames > 3);
  assert.equal(await language(), 'de');
  assert.equal(await page.inputValue('#language'), 'de');
  await until(() => /^\d+(\.\d+)? ms$/.test(document.querySelector('#sessions tbody tr').cells[5].textContent));
});

test('in another language no English text is left', async () => {
  const everything = async (locale) => {
    await show(locale);
    await press('w');
    await press('w');
    await press('h');
    await page.locator('#times table').first().waitFor();
    await press('Escape');
    return (await texts()).filter((text) => !/alice|mock/.test(text));  // Names that the server gives.
  };
  const german = await everything('de-DE');
  const own = new Set(Object.values(TEXTS).map(([english]) => english));
  const isName = (text) => /^[a-z_]+$/.test(text);  // of a reason or of a setting, as everywhere
  const same = new Set(Object.values(TEXTS).filter(([english, other]) => english === other).map(([english]) => english));
  assert.deepEqual(german.filter((text) => own.has(text) && !same.has(text) && !isName(text)), []);
  // Names, units, keys and values are the same in both languages.
  const english = new Set(await everything('en-US'));
  const both = german.filter((text) => english.has(text) && !same.has(text) && /[a-z]{3}.* .*[a-z]{3}/i.test(text));
  assert.deepEqual(both, []);
});
