// The bar below the scene: scales, camera, image and link. Every wait is for a condition.

import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {test} from 'node:test';
import {readLink} from '../page/src/link.js';
import {TOKEN} from './mock_server.mjs';
import {hold, newPage, newServer, open, page, press, server, state, until} from './page_fixture.mjs';

const begun = () => until(() => window.feltwire().pictures > 3 && window.feltwire().frames > 2);

/** @returns {Promise<number>} the largest difference to a color of the theme, of the nearest pixel around a place of the view */
const differenceAt = async (picture, {x, y}, name) => page.evaluate(async ([base64, at, variable]) => {
  const image = new Image();
  image.src = `data:image/png;base64,${base64}`;
  await image.decode();
  const canvas = document.createElement('canvas');
  [canvas.width, canvas.height] = [image.width, image.height];
  const context = canvas.getContext('2d');
  context.drawImage(image, 0, 0);
  const wanted = getComputedStyle(document.documentElement).getPropertyValue(variable).trim();
  const color = [1, 3, 5].map((from) => parseInt(wanted.slice(from, from + 2), 16));
  const {data} = context.getImageData(Math.round(at.x) - 2, Math.round(at.y) - 2, 5, 5);
  const differences = Array.from({length: 25}, (_, i) => Math.max(...color.map((value, k) => Math.abs(data[4 * i + k] - value))));
  return Math.min(...differences);
}, [picture.toString('base64'), {x, y}, `--${name}`]);

test('the axes are seen in both themes, and nothing lies over them', async () => {
  for (const colorScheme of ['light', 'dark']) {
    await newPage({viewport: {width: 1360, height: 860}, deviceScaleFactor: 1, colorScheme});
    await open();
    await begun();
    await hold();
    const picture = await page.locator('#canvas').screenshot();
    const {axes: [origin, ...ends]} = await state();
    for (const end of ends) {
      for (const share of [0.1, 0.3, 0.5]) {
        const place = {x: origin.x + share * (end.x - origin.x), y: origin.y + share * (end.y - origin.y)};
        const difference = await differenceAt(picture, place, 'ink');
        assert.ok(difference < 60, `${colorScheme}, ${share} of the way to ${JSON.stringify(end)}: ${difference}`);
      }
    }
  }
});

test('arrows scale by themselves and say their scale, until the user scales them', async () => {
  server.play.gain = 60;
  await open();
  await begun();
  const scale = () => page.textContent('#arrow-scale');
  const fits = () => {
    const {longestArrow, strongest, viewHeight} = window.feltwire();
    return strongest > 60 && longestArrow > 0.03 * viewHeight && longestArrow < 0.45 * viewHeight;
  };
  await until(fits);
  const strong = await scale();
  assert.match(strong, /^1 N = [\d.]+ mm$/);
  server.play.gain = 0.2;
  await until((before) => document.querySelector('#arrow-scale').textContent !== before, strong);  // The strong forces are forgotten.
  await press('.');
  assert.equal(await page.getAttribute('#arrow-auto', 'aria-pressed'), 'false');
  const own = await scale();
  server.play.gain = 60;
  await until(() => window.feltwire().longestArrow > 2 * window.feltwire().viewHeight);
  assert.equal(await scale(), own);
  await press('a');
  await until(fits);
});

test('the camera follows a hand, until all is shown', async () => {
  await open();
  await begun();
  await press('1');
  const {pose: before} = await state();
  await press('c');
  assert.equal(await page.getAttribute('#follow', 'aria-pressed'), 'true');
  const near = (reach) => {
    const {width, height} = document.querySelector('#canvas').getBoundingClientRect();
    const {x, y} = window.feltwire().places[0];
    return Math.hypot(x - width / 2, y - height / 2) < reach;
  };
  await until(near, 40);
  server.play.away = [0.3, 0.2, 0];
  await until((target) => Math.hypot(...window.feltwire().pose.target.map((value, i) => value - target[i])) > 0.3, before.target);
  await until(near, 40);
  await press('f');
  assert.equal(await page.getAttribute('#follow', 'aria-pressed'), 'false');
  await hold();
  const seen = await page.evaluate(() => {
    const {width, height} = document.querySelector('#canvas').getBoundingClientRect();
    return window.feltwire().places.map(({x, y}) => x > 0 && x < width && y > 0 && y < height);
  });
  assert.deepEqual(seen, [true, true], 'also the hand outside of the scene');
});

test('a plane is hatched from within the solid', async () => {
  await newServer({hands: 1, bodies: 0});
  Object.assign(server.play, {still: true, modelled: false});
  await newPage({viewport: {width: 900, height: 640}, deviceScaleFactor: 1});
  await open();
  await begun();
  /** Share of the pixels that are between the surface and its lines. */
  const drawn = async () => {
    const {frames} = await state();
    await press('ArrowLeft');
    await until((before) => window.feltwire().frames > before, frames);
    const picture = await page.locator('#canvas').screenshot();
    return page.evaluate(async (base64) => {
      const image = new Image();
      image.src = `data:image/png;base64,${base64}`;
      await image.decode();
      const canvas = document.createElement('canvas');
      [canvas.width, canvas.height] = [image.width, image.height];
      const context = canvas.getContext('2d');
      context.drawImage(image, 0, 0);
      const {data} = context.getImageData(0, 0, canvas.width, canvas.height);
      let count = 0;
      for (let i = 0; i < data.length; i += 4) if (data[i] > 160 && data[i] < 205) count += 1;
      return (4 * count) / data.length;
    }, picture.toString('base64'));
  };
  const above = await drawn();
  assert.ok((await state()).pose.position[2] > 0);
  for (let i = 0; i < 9; ++i) await press('ArrowDown');
  const below = await drawn();
  assert.ok((await state()).pose.position[2] < 0);
  assert.ok(below > 1.5 * above, `${above} from above, ${below} from below`);
});

test('a link with a view that no camera can have keeps its scene and hand', () => {
  for (const view of ['0,0,0,0,0,0', '1,2,3,1,2,3', ',,,,,1', '1e308,0,0,-1e308,0,0', 'nan,0,0,0,0,1', '1,2,3', '1,2,3,4,5,6,7']) {
    assert.deepEqual(readLink(`#scene=room&hand=2&view=${view}`), {scene: 'room', hand: 2, pose: null}, view);
  }
  assert.deepEqual(readLink('#view=0.5,-1,0.4,0,0,0').pose, {position: [0.5, -1, 0.4], target: [0, 0, 0]});
});

test('a link holds scene, hand and camera, and no token', async () => {
  await open();
  await begun();
  await page.selectOption('#scenes', 'other');
  await until(() => window.feltwire().scene === 'other' && window.feltwire().hands.length === 2);
  await press('2');
  for (const key of ['ArrowLeft', 'ArrowUp', '+', '+']) await press(key);
  const {pose} = await state();
  await press('u');
  await until(() => /link to this view/.test(document.querySelector('#link-said').textContent));
  const link = page.url();
  assert.ok(!link.includes(TOKEN), link);
  await newPage();
  await page.goto(`${link}&token=${TOKEN}`);
  await until(() => window.feltwire().scene === 'other' && window.feltwire().chosen === 2 && window.feltwire().frames > 2);
  assert.equal(page.url(), link);
  const shown = (await state()).pose;
  for (const part of ['position', 'target']) pose[part].forEach((value, i) => assert.ok(Math.abs(value - shown[part][i]) < 1e-4, `${part}: ${shown[part]}`));
  assert.deepEqual(server.watched.at(-1), 'other');
});

test('an image of the scene has what is drawn, and a line with its scales', async () => {
  await newPage({viewport: {width: 900, height: 640}, deviceScaleFactor: 1});
  await open();
  for (let long = false; !long; long = (await state()).longestArrow > 0.03) {  // Until the picture that is held has a long arrow.
    if ((await state()).held) await press(' ');
    await until(() => window.feltwire().longestArrow > 0.03);
    await hold();
  }
  const [download] = await Promise.all([page.waitForEvent('download'), press('i')]);
  assert.match(download.suggestedFilename(), /^feltwire-room-.*\.png$/);
  const bytes = readFileSync(await download.path());
  const {width, height, counts} = await page.evaluate(async (base64) => {
    const image = new Image();
    image.src = `data:image/png;base64,${base64}`;
    await image.decode();
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [image.width, image.height];
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const style = getComputedStyle(document.documentElement);
    const count = (name, from, to) => {
      const wanted = style.getPropertyValue(`--${name}`).trim();
      const color = [1, 3, 5].map((at) => parseInt(wanted.slice(at, at + 2), 16));
      const {data} = context.getImageData(0, from, canvas.width, to - from);
      let found = 0;
      for (let i = 0; i < data.length; i += 4) if (color.every((value, k) => Math.abs(data[i + k] - value) < 24)) found += 1;
      return found;
    };
    const end = canvas.height - 26;
    return {width: canvas.width, height: canvas.height, counts: {arrows: count('elastic', 0, end), view: count('view', 0, end), key: count('elastic', end, canvas.height), words: count('muted', end, canvas.height)}};
  }, bytes.toString('base64'));
  const room = await page.locator('#canvas').boundingBox();
  assert.deepEqual([width, height], [room.width, room.height + 26]);
  assert.ok(counts.arrows > 30 && counts.view > 1000 && counts.key > 30 && counts.words > 100, JSON.stringify(counts));
});

test('fingers are told what they do, and keys stand in their buttons', async () => {
  await newPage({viewport: {width: 1360, height: 860}});
  await open();
  await begun();
  const key = () => page.locator('#follow').evaluate((button) => [getComputedStyle(button, '::after').content, getComputedStyle(button, '::after').display]);
  assert.deepEqual(await key(), ['"c" / ""', 'inline']);  // Screen readers read it from the attribute alone.
  assert.ok(await page.locator('#touch').isHidden());
  await newPage({viewport: {width: 390, height: 800}, isMobile: true, hasTouch: true});
  await open();
  await begun();
  assert.equal((await key())[1], 'none');
  assert.match(await page.textContent('#touch'), /One finger turns, two fingers move and zoom/);
  assert.ok(await page.locator('#touch').isVisible());
});
