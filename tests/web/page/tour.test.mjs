// The guided tour on the page of a real server with its simulated hands. Every wait is for a condition.
// FELTWIRE_PROGRAMS: the folder of the programs. FELTWIRE_TOUR_SCENE: the scene of the tour.

import assert from 'node:assert/strict';
import {test} from 'node:test';
import {open, ownToken, serve, token} from './real_server.mjs';

const SCENE = process.env.FELTWIRE_TOUR_SCENE;
const look = (page) => page.evaluate(() => window.feltwire().tour);

/** Waits until the table says that the page's hand has this law. */
const hasLaw = (page, mode) => page.waitForFunction((wanted) => {
  const {own} = window.feltwire();
  const row = [...document.querySelectorAll('#sessions tbody tr')].find(({cells}) => cells[0].textContent === String(own.number));
  return own.state === 'held' && [...row?.cells ?? []].some(({title}) => title === `${wanted}, at the client`);  // A narrow column cuts what it shows.
}, mode);

/** Waits until the table says that every simulated hand has a round trip in these limits [ms]. */
const travels = (page, from, to) => page.waitForFunction(([least, most]) => {
  const place = [...document.querySelectorAll('#sessions thead th')].findIndex(({textContent}) => textContent === 'Round trip');
  const times = [...document.querySelectorAll('#sessions tbody tr')].map((row) => parseFloat(row.cells[place].textContent));
  return times.length === 2 && times.every((time) => time >= least && time < most);
}, [from, to]);

/** The figure as a picture, once it has lines, and how many of its pixels are drawn. */
async function drawn(page) {
  const read = () => {
    const canvas = document.querySelector('#tour canvas');
    const {data} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let inked = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 100) inked += 1;
    return {url: canvas.toDataURL(), inked};
  };
  await page.waitForFunction(() => window.feltwire().tour.rows > 60);
  return page.evaluate(read);
}

const next = async (page) => {
  await page.locator('#tour .steps button').nth(1).focus();
  await page.keyboard.press('Enter');
};

test('each step changes the law or the delay of a hand, and measures it', async () => {
  await serve(SCENE, '--demo');
  const page = await open(ownToken('admin'));
  await page.waitForFunction(() => window.feltwire().hands.length === 2);
  await page.keyboard.press('w');
  await hasLaw(page, 'none');
  await page.waitForFunction(() => window.feltwire().tour.results['law.none']?.depth > 0);
  const figures = [];  // of each step: what it draws, and its pixels
  const keepFigure = async () => figures.push({panels: (await look(page)).figure.join(), picture: await drawn(page)});
  await keepFigure();
  await next(page);
  await hasLaw(page, 'total_energy');
  await keepFigure();
  for (const [place, mode] of [[1, 'per_axis'], [2, 'per_axis_projected']]) {
    await page.locator('#tour .choices button').nth(place).press('Enter');
    await hasLaw(page, mode);
    assert.equal(await page.locator('#tour .choices [aria-pressed=true]').textContent(), `Eq. ${place + 1}`);
    await keepFigure();
  }
  await next(page);
  await hasLaw(page, 'shaped');
  await page.waitForFunction(() => window.feltwire().tour.results['law.usual']?.depth > 0);
  await keepFigure();
  assert.equal(await page.evaluate(() => document.activeElement.id), 'tour-title');  // A screen reader reads the new step.
  await next(page);
  const {results} = await look(page);
  assert.ok(results['law.none'].shakes > results['law.usual'].shakes, JSON.stringify(results));
  await page.waitForFunction(() => window.feltwire().own.state === 'free');
  await travels(page, 50, 90);
  await page.waitForFunction(() => window.feltwire().tour.results['hand.delay']?.depth > 0);
  await keepFigure();
  await next(page);
  await travels(page, 100, 150);
  await page.waitForFunction(() => window.feltwire().tour.results['hand.model']?.depth > 0);
  await keepFigure();
  figures.forEach(({panels, picture}, i) => {
    assert.ok(picture.inked > 200, `figure ${i}: ${picture.inked} pixels`);
    figures.slice(0, i).forEach((other, k) => {
      assert.notEqual(picture.url, other.picture.url, `figures ${k} and ${i}`);
      if (!(k === 5 && i === 6)) assert.notEqual(panels, other.panels, `figures ${k} and ${i}`);  // Both have force over depth.
    });
  });
  assert.ok(await page.locator('#tour .steps button').nth(1).isDisabled());
  await page.keyboard.press('w');
  await travels(page, 0, 40);
});

test('what the page may not do says what unlocks it', async () => {
  await serve(SCENE, '--demo');
  const watcher = await open(token('observer'));
  await watcher.keyboard.press('w');
  await watcher.waitForFunction(() => /^Locked: this page may hold no hand\. A token of the role pointer/.test(document.querySelector('#tour-said').textContent));
  await watcher.context().close();

  const page = await open(ownToken('local'));
  await page.waitForFunction(() => window.feltwire().hands.length === 2);
  await page.keyboard.press('w');
  await hasLaw(page, 'none');
  for (let step = 1; step < 4; ++step) await next(page);
  await page.waitForFunction(() => /^Locked: only an admin may delay a hand\./.test(document.querySelector('#tour-said').textContent));
  await page.getByRole('button', {name: 'Enter a token'}).click();
  await page.fill('#admin input[type=password]', ownToken('admin'));
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => !document.querySelector('#admin fieldset').disabled);
  await page.keyboard.press('Tab');
  await page.locator('#tour-open').click();
  await travels(page, 50, 90);
});

test('a page that shall move little moves the hand only when it is told to, and a user who moves it is left alone', async () => {
  await serve(SCENE);
  const page = await open(ownToken('local'), {reducedMotion: 'reduce'});
  await page.keyboard.press('w');
  await hasLaw(page, 'none');
  const {target} = await page.evaluate(() => window.feltwire().own);
  await page.waitForFunction(() => window.feltwire().tour.rows > 30);
  assert.deepEqual((await page.evaluate(() => window.feltwire().own)).target, target);
  await page.getByRole('button', {name: 'Move it for me'}).click();
  await page.waitForFunction((z) => window.feltwire().own.target[2] < z - 0.02, target[2]);
  await page.locator('#canvas').focus();
  await page.keyboard.press('PageUp');
  assert.equal((await look(page)).moves, false);
});

test('a scene without a stiff wall says which scene the tour needs', async () => {
  await serve(SCENE.replace('tour.json', 'room.json'));
  const page = await open(ownToken('local'));
  await page.keyboard.press('w');
  await page.waitForFunction(() => /^Locked: the tour needs a stiff wall\. Start the server with scenes\/tour\.json\.$/.test(document.querySelector('#tour-said').textContent));
  assert.equal((await page.evaluate(() => window.feltwire().own)).state, 'free');
});
