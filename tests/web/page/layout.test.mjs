// The page's layout: the table of hands, names that are placed apart, whole lines, and the admin's panel beside the scene.

import assert from 'node:assert/strict';
import {test} from 'node:test';
import {bits, REASONS} from './members.mjs';
import {newPage, newServer, open, page, server, state, until} from './page_fixture.mjs';

/** Opens the page with this many hands. @param {object} [viewport] @param {object} [options] of the browser's context */
async function show(hands, viewport = {width: 1360, height: 860}, options = {}) {
  await newServer({hands});
  await newPage({viewport, ...options});
  await open();
  await until((count) => window.feltwire().pictures > 3 && document.querySelectorAll('tbody tr').length === count, hands);
}

const headings = () => page.locator('thead th:visible').allTextContents();
const column = (name) => page.evaluate((wanted) => {
  const place = [...document.querySelectorAll('thead th')].findIndex(({textContent}) => textContent === wanted);
  return [...document.querySelectorAll('tbody tr')].map((row) => row.cells[place].textContent);
}, name);

test('the table has the columns that fit, and others that the user chooses and the browser keeps', async () => {
  await show(2);
  const narrow = await headings();
  assert.ok(narrow.includes('Force') && narrow.includes('Bounded by') && !narrow.includes('Samples'), narrow.join());
  await page.setViewportSize({width: 1920, height: 860});
  await until((before) => [...document.querySelectorAll('thead th')].filter((cell) => !cell.hidden).length > before, narrow.length);
  await page.setViewportSize({width: 1360, height: 860});
  await page.click('#columns summary');
  await page.locator('#columns').getByLabel('Samples', {exact: true}).check();
  await page.locator('#columns').getByLabel('Loss', {exact: true}).uncheck();
  const chosen = await headings();
  assert.ok(chosen.includes('Samples') && !chosen.includes('Loss'), chosen.join());
  await page.reload();
  await until(() => document.querySelectorAll('tbody tr').length === 2);
  assert.deepEqual(await headings(), chosen);
  await page.click('#columns summary');
  await page.click('#columns button');
  assert.deepEqual(await headings(), narrow);
});

test('a click on a heading sorts the rows, a second one the other way round', async () => {
  await show(4);
  const heading = page.locator('thead button', {hasText: 'Round trip'});
  await heading.click();
  assert.deepEqual(await column('Client'), ['alice', 'bob', 'carol', 'dave']);  // What is unknown comes last.
  await heading.click();
  assert.deepEqual(await column('Client'), ['dave', 'carol', 'bob', 'alice']);
  assert.equal(await page.locator('thead th[aria-sort="descending"]').textContent(), 'Round trip');
  await page.click('#columns summary');
  await page.selectOption('#columns select', {label: 'Client'});
  assert.deepEqual(await column('Client'), ['alice', 'bob', 'carol', 'dave']);
});

test('on a phone each hand is a card', async () => {
  await show(3, {width: 360, height: 800}, {isMobile: true, hasTouch: true});
  const cards = await page.locator('tbody tr').evaluateAll((rows) => rows.map((row) => {
    const {left, right, height} = row.getBoundingClientRect();
    return {left, right, height, names: [...row.cells].filter((cell) => !cell.hidden).map((cell) => getComputedStyle(cell, '::before').content)};
  }));
  for (const {left, right, height, names} of cards) {
    assert.ok(left >= 0 && right <= 360 && height > 60, `${left} to ${right}, ${height} high`);
    assert.ok(names.includes('"Force"'), names.join());
  }
  assert.ok(await page.locator('thead').isHidden());
});

test('long names lose their middle, and are whole on hover', async () => {
  const long = 'laboratory-of-robotics-and-haptics-station-17';
  await show(1);
  server.play.names = [long];
  await until(() => /…/.test(document.querySelector('tbody td:nth-child(2)').textContent));
  const cell = page.locator('tbody td:nth-child(2)');
  assert.equal(await cell.getAttribute('title'), long);
  for (const width of [1000, 1360, 1920]) {
    await page.setViewportSize({width, height: 860});
    await until((wanted) => {  // as long as the column is wide: two more letters would not fit
      const box = document.querySelector('tbody td:nth-child(2)');
      const text = document.createRange();
      text.selectNodeContents(box);
      const spare = box.clientWidth - 16 - text.getBoundingClientRect().width;
      return innerWidth === wanted && spare >= 0 && spare < 22;
    }, width);
    const [begin, end] = (await cell.textContent()).split('…');
    assert.ok(long.startsWith(begin) && long.endsWith(end) && Math.abs(begin.length - end.length) <= 1, `${begin}…${end}`);
    const cut = await page.evaluate(() => [...document.querySelectorAll('tbody td')].filter((box) => box.scrollWidth > box.clientWidth).map((box) => box.textContent));
    assert.deepEqual(cut, [], `${width} px`);
    assert.equal(await cell.evaluate((box) => getComputedStyle(box).textOverflow), 'clip');
  }
  await until((name) => document.querySelector('#chosen').title === `${name}, hand 1`, long);
  await until(() => /…/.test(document.querySelector('#labels .chosen').textContent));
});

test('the strip of reasons shows whole lines', async () => {
  await show(1);
  server.play.reasons = REASONS.reduce((all, _, bit) => all | 1 << bit, 0);
  await until((count) => [...document.querySelectorAll('#reasons li')].filter((item) => !item.hidden).length === count, REASONS.length);
  const cut = () => page.evaluate(() => {
    const {top, bottom} = document.querySelector('#reasons').getBoundingClientRect();
    return [...document.querySelectorAll('#reasons li')].map((item) => item.getBoundingClientRect()).filter((box) => (
      box.height > 0 && box.top < bottom - 1 && box.bottom > top + 1 && (box.top < top - 1 || box.bottom > bottom + 1))).length;
  });
  assert.equal(await cut(), 0);
  await page.evaluate(() => (document.querySelector('#reasons').scrollTop = 37));
  await until(() => document.querySelector('#reasons').scrollTop % 28 === 0);
  assert.equal(await cut(), 0);
  server.play.reasons = bits('waiting');
  assert.equal(await page.evaluate(() => document.querySelector('#why').scrollHeight - document.querySelector('#why').clientHeight), 0);
});

test('reasons that take force off come before those that do not', async () => {
  await show(1);
  server.play.reasons = bits('touching', 'near', 'limits');
  const shown = () => page.locator('#reasons li:visible').evaluateAll((items) => items.map(({title}) => title));
  await until(() => [...document.querySelectorAll('#reasons li')].filter((item) => !item.hidden).map(({title}) => title).sort().join() === 'limits,near,touching');
  assert.deepEqual(await shown(), ['limits', 'touching', 'near']);
});

test('the panel of admins covers neither the scene nor a name, and says what unlocks it', async () => {
  for (const width of [1360, 1000]) {
    await show(2, {width, height: 860});
    await page.click('#admin-open');
    await until(() => document.querySelector('#canvas').getBoundingClientRect().right <= document.querySelector('#admin').getBoundingClientRect().left + 1);
    assert.match(await page.textContent('#admin form'), /Locked.*an admin changes them.*Token of an admin/);
    assert.equal(await page.locator('#admin input[type=number]').first().evaluate((input) => getComputedStyle(input).borderStyle), 'dashed');
    await page.focus('#admin-object-tab');
    await page.keyboard.press('ArrowRight');
    assert.ok(await page.locator('#admin-hand').isVisible() && await page.locator('#admin-object').isHidden());
  }
});

test('names of hands do not lie on each other; those without a place are counted', async () => {
  await show(16);
  const boxes = () => page.evaluate(() => [...document.querySelectorAll('#labels div:not(.axis)')].filter((label) => label.style.visibility !== 'hidden')
    .map((label) => label.getBoundingClientRect()).map(({left, right, top, bottom}) => ({left, right, top, bottom})));
  await page.keyboard.press(' ');
  await until(() => window.feltwire().held && !document.querySelector('#labels p').hidden);
  const shown = await boxes();
  shown.forEach((a, i) => shown.slice(i + 1).forEach((b) => (
    assert.ok(a.left >= b.right || b.left >= a.right || a.top >= b.bottom || b.top >= a.bottom, JSON.stringify([a, b])))));
  const counted = Number((await page.textContent('#labels p')).match(/\d+/)[0]);
  assert.equal(shown.length + counted, (await state()).hands.length);
});
