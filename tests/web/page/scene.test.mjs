// Drawings of the live page. Every wait is for a condition.

import assert from 'node:assert/strict';
import {test} from 'node:test';
import {TOKEN} from './mock_server.mjs';
import {boxShape, cupShape, gridShape} from './play.mjs';
import {hold, newPage, newServer, open, page, pixels, press, server, state, until} from './page_fixture.mjs';

test('nothing is drawn before there is a scene', async () => {
  await page.goto(server.url);
  await page.locator('#token-text').waitFor();
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done)))));
  assert.equal((await state()).frames, 0);
  await page.fill('#token-text', TOKEN);
  await press('Enter');
  await until(() => window.feltwire().firstPicture !== null);
});

test('a scene without pictures is drawn all the same', async () => {
  server.play.silent = true;
  await open();
  await until(() => window.feltwire().frames > 0);
  assert.equal((await state()).pictures, 0);
});

test('the view has the background of the theme', async () => {
  await open();
  await until(() => window.feltwire().firstPicture !== null);
  const area = await page.evaluate(() => document.querySelector('#canvas').width * document.querySelector('#canvas').height);
  for (let theme = 0; theme < 2; ++theme) {
    const share = (await pixels('view')) / area;
    assert.ok(share > 0.2, `${share} of the view`);
    const frames = (await state()).frames;
    await press('l');
    await until((drawn) => window.feltwire().frames > drawn, frames);
  }
});

test('arrows move and are seen', async () => {
  await newPage({deviceScaleFactor: 1});
  server.play.still = true;
  await open();
  await until(() => window.feltwire().pictures > 5 && window.feltwire().frames > 2 && window.feltwire().longestArrow === 0);
  const legend = await pixels('elastic');
  server.play.still = false;
  await until(() => window.feltwire().longestArrow > 0.03);
  await hold();
  // The picture on hold may be of a moment with small forces.
  let short = await pixels('elastic') - legend;
  for (let tries = 0; short <= 30 && tries < 20; ++tries) {
    await press(' ');
    const {pictures} = await state();
    await until((seen) => window.feltwire().pictures > seen + 5, pictures);
    await hold();
    short = await pixels('elastic') - legend;
  }
  assert.ok(short > 30, `${short} pixels`);
  const {frames} = await state();
  const metres = async () => (([, number, unit]) => number * {mm: 1e-3, cm: 1e-2, m: 1}[unit])(
    /1 N = ([0-9.]+) (mm|cm|m)$/.exec(await page.textContent('#arrow-scale')));
  const before = await metres();  // It depends on how long the hands were still.
  await press('.');
  await until((drawn) => window.feltwire().frames > drawn, frames);
  const factor = (await metres()) / before;
  assert.ok(factor > 1.9 && factor < 2.6, `${before} m for a newton, and then ${factor} times as much`);
  const long = await pixels('elastic') - legend;
  assert.ok(long > 1.3 * short, `${long} pixels after ${short}`);
});

test('tools and local models are drawn', async () => {
  await open();
  await until(() => window.feltwire().toolBalls === 1 && window.feltwire().toolPoints === 60 && window.feltwire().surfaces === 1);
  await press('s');
  await until(() => window.feltwire().surfaces === 0);
  await press('s');
  await until(() => window.feltwire().surfaces === 1);
  server.play.modelled = false;
  await until(() => window.feltwire().surfaces === 0);
});

test('a contact has the normal of the surface that the hand touches, else the direction of its elastic force', async () => {
  await newServer({hands: 2});
  const touching = ({contacts}) => [1, 2].map((number) => contacts.filter((contact) => contact.number === number));
  await open();
  await until(() => window.feltwire().surfaces === 1 && [1, 2].every((number) => window.feltwire().contacts.some((contact) => contact.number === number)));
  await hold();
  const [modelled, plain] = touching(await state());
  assert.equal(modelled.length, 1);
  assert.deepEqual(modelled[0].normal, [0, 0, 1]);
  assert.ok(Math.abs(modelled[0].at[2]) < 1e-6, `${modelled[0].at}`);  // on the floor
  assert.equal(plain.length, 1);
  assert.ok(Math.abs(Math.hypot(...plain[0].normal) - 1) < 1e-5 && Math.abs(plain[0].normal[2] - Math.cos(0.5)) < 1e-5, `${plain[0].normal}`);  // on the ball
  await press(' ');
  server.play.still = true;
  await until(() => window.feltwire().contacts.length === 0);
});

test('edges of objects are drawn, also of one that moves, and round ones have none', async () => {
  await newServer({hands: 1, bodies: 3});
  server.play.shapes.find(({index}) => index === 2).shape = boxShape([0.02, 0.02, 0.02]);
  await open();
  await until(() => window.feltwire().bodies === 3 && window.feltwire().edges.length > 1);
  assert.deepEqual((await state()).edges, [{index: 1, segments: 12}, {index: 2, segments: 12}]);
});

test('a mesh and a grid that move are drawn where the picture says', async () => {
  await newServer({hands: 1, bodies: 6});
  const [cup, grid] = [cupShape(0.02, 0.03), gridShape(0.015)];
  server.play.shapes.find(({index}) => index === 2).shape = cup;
  server.play.shapes.find(({index}) => index === 3).shape = grid;
  await open();
  await until(() => window.feltwire().bodies === 6 && window.feltwire().pictures > 1);
  await hold();
  const {bodyPlaces, time} = await state();
  const triangles = (index) => bodyPlaces.find((body) => body.index === index).triangles;
  assert.equal(triangles(2), cup.corners.length / 3);
  assert.equal(triangles(3), grid.corners.length / 3);
  assert.notEqual(triangles(4), triangles(3));  // Four balls of one shape are drawn together, beside them.
  for (const i of [0, 1, 4]) {
    const {at} = bodyPlaces.find(({index}) => index === 2 + i);
    server.play.place(i, time).forEach((value, axis) => assert.ok(Math.abs(value - at[axis]) < 1e-5, `body ${i}: ${at}`));
  }
});

test('of pictures that come in a heap the newest is drawn, and all are plotted', async () => {
  await open();
  await page.selectOption('#seconds', '60');  // All points stay in the plots.
  await until(() => window.feltwire().pictures > 3 && window.feltwire().plotted.points > 3);
  server.play.silent = true;
  server.send(server.play.picture());
  const last = server.play.picture();
  server.send(last);
  await until((time) => window.feltwire().time === time, last.readDoubleLE(16));  // What was on its way has come.
  const before = await state();
  const heap = Array.from({length: 40}, (_, i) => {
    const picture = server.play.picture();
    picture.writeDoubleLE(before.time + 0.01 * (i + 1), 16);
    return picture;
  });
  heap.forEach((picture) => server.send(picture));
  await until((time) => window.feltwire().time > time, before.time + 0.395);
  await until((points) => window.feltwire().plotted.points >= points, before.plotted.points + 40);  // A plot is at most as new as its picture.
  const after = await state();
  assert.equal(after.pictures, before.pictures + 40);
  assert.ok(after.frames - before.frames < 20, `${after.frames - before.frames} frames`);
});

test('robots are drawn and described', async () => {
  await open();
  await until(() => window.feltwire().pictures > 1);
  const described = (lines) => until((lines) => lines === [...document.querySelectorAll('#robots p:not([hidden])')].map((line) => line.textContent).join('; '), lines.join('; '));
  assert.deepEqual((await state()).robots, []);
  await described([]);
  server.play.robots = [{state: 2, hand: 1, flags: 1 | 2 | 8}];
  await until(() => window.feltwire().robots[0]?.forces === 1);
  await described(['robot: engaged led by hand 1, 5.00 N on its tool, touches']);
  const near = (a, b) => a.every((value, i) => Math.abs(value - b[i]) < 1e-6);
  const {robots: [robot]} = await state();
  assert.ok(near(robot.tool, [0.02, 0.03, 0.04]) && near(robot.target, [0.02, 0.03, 0.02]), JSON.stringify(robot));
  server.play.robots = [{state: 5, hand: 0, flags: 4}];
  await until(() => window.feltwire().robots[0]?.forces === 0);
  await described(['robot: fault led by no hand, senses no force, protective stop']);

  server.play.seats = ['left', 'right'];
  server.play.robots = [{state: 1, hand: 0, flags: 2}, {state: 2, hand: 3, flags: 1 | 2 | 1 << 8}];
  await open();
  await until(() => window.feltwire().robots.length === 2);
  await described(['robot left: ready led by no hand, senses no force', 'robot right: engaged led by hand 3, 5.00 N on its tool']);
  server.play.robots = [{state: 2, hand: 3, flags: 1 | 2 | 1 << 8}];  // the left one has left
  await until(() => window.feltwire().robots.length === 1);
  await described(['robot right: engaged led by hand 3, 5.00 N on its tool']);
  server.play.seats = [''];
  server.play.robots = [];
  await until(() => window.feltwire().robots.length === 0);
  await described([]);
});

test('choosing a hand changes plots, strip and table', async () => {
  await open();
  await until(() => window.feltwire().plotted.points > 5 && document.querySelector('tbody tr'));
  await until(() => document.querySelector('#chosen').textContent.includes('alice'));
  await press('2');
  await until(() => window.feltwire().chosen === 2 && document.querySelector('#chosen').textContent.includes('bob'));
  await until(() => Math.abs(window.feltwire().plotted.last[3][1] - 1.3) < 1e-3);  // bob's loss
  assert.equal(await page.textContent('tr[aria-selected="true"] td:nth-child(2)'), 'bob');
  await page.locator('tbody tr').first().click();
  await until(() => window.feltwire().chosen === 1 && Math.abs(window.feltwire().plotted.last[3][1]) < 1e-3);
  await hold();  // Hands stand still for the click.
  const {places} = await state();
  const bob = places.find(({number}) => number === 2);
  await page.locator('#canvas').click({position: {x: bob.x, y: bob.y}});
  await until(() => window.feltwire().chosen === 2);
});

test('a click on a hand chooses it, also where a name lies over it', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3 && document.querySelectorAll('#labels div:not(.axis)').length > 1);
  await press('1');
  await until(() => window.feltwire().chosen === 1);
  await hold();
  const {places} = await state();
  const bob = places.find(({number}) => number === 2);
  // The name of alice covers the view.
  await page.locator('#labels div', {hasText: 'alice'}).evaluate((label) => (label.getBoundingClientRect = () => new DOMRect(0, 0, 4000, 4000)));
  await page.locator('#canvas').click({position: {x: bob.x, y: bob.y}});
  await until(() => window.feltwire().chosen === 2);
  await page.locator('#canvas').click({position: {x: 3, y: 3}});
  await until(() => window.feltwire().chosen === 1);
});

test('guides are seen: lines, and shapes that one can look through', async () => {
  const green = async () => {
    const picture = await page.locator('#canvas').screenshot();
    return page.evaluate(async (base64) => {
      const image = new Image();
      image.src = `data:image/png;base64,${base64}`;
      await image.decode();
      const canvas = document.createElement('canvas');
      [canvas.width, canvas.height] = [image.width, image.height];
      const context = canvas.getContext('2d');
      context.drawImage(image, 0, 0);
      const {data} = context.getImageData(0, 0, image.width, image.height);
      let count = 0;
      for (let i = 0; i < data.length; i += 4) if (data[i + 1] > data[i] + 8 && data[i + 1] > data[i + 2] + 8) count += 1;
      return count;
    }, picture.toString('base64'));
  };
  await newPage({deviceScaleFactor: 1});
  await newServer({hands: 1, bodies: 0});  // Nothing else that is green moves.
  Object.assign(server.play, {modelled: false, still: true});
  await open();
  await until(() => window.feltwire().pictures > 3 && window.feltwire().frames > 2);
  assert.equal((await state()).guides, 2);  // The third acts everywhere.
  const all = await green();
  const withGuides = async (names, scene) => {
    server.play.guided = names;
    await page.selectOption('#scenes', scene);
    await until(([wanted, count]) => window.feltwire().scene === wanted && window.feltwire().guides === count, [scene, names.length]);
    await until((before) => window.feltwire().frames > before, (await state()).frames);
    return green();
  };
  const rail = await withGuides(['rail'], 'other');
  const none = await withGuides([], 'room');
  assert.ok(all - rail > 1000, `${all - rail} pixels of a shape`);
  assert.ok(rail - none > 100, `${rail - none} pixels of a line`);
});

test('the geometry of objects is drawn where the server says', async () => {
  await open();
  await until(() => window.feltwire().solids.length === 1);
  const [{index, triangles, low, high}] = (await state()).solids;
  assert.deepEqual([index, triangles], [1, 12]);
  [-0.09, -0.02, 0].forEach((value, axis) => assert.ok(Math.abs(low[axis] - value) < 1e-6));
  [-0.05, 0.08, 0.024].forEach((value, axis) => assert.ok(Math.abs(high[axis] - value) < 1e-6));
});

test('trails grow behind hands that move, and can be hidden', async () => {
  await open();
  await until(() => window.feltwire().trails.length === 2 && window.feltwire().trails.every((length) => length > 0.01));
  await press('t');
  await until(() => window.feltwire().trails.length === 0);
  await press('t');
  await until(() => window.feltwire().trails.length === 2);
});

test('the camera turns by keys and by mouse, and panels can be resized', async () => {
  await open();
  await until(() => window.feltwire().places.length === 2 && window.feltwire().frames > 2);
  await hold();
  const first = (await state()).places[0];
  const moved = ([x, y]) => Math.hypot(window.feltwire().places[0].x - x, window.feltwire().places[0].y - y) > 5;
  for (const key of ['ArrowLeft', 'ArrowLeft', 'ArrowLeft', 'ArrowLeft', 'ArrowUp']) await press(key);  // A hand may be near the axis.
  await until(moved, [first.x, first.y]);
  const second = (await state()).places[0];
  const name = await page.locator('#labels div', {hasText: 'bob'}).boundingBox();  // A label does not stop the drag. This one is beside the legend.
  await page.mouse.move(name.x + 5, name.y + 5);
  await page.mouse.down();
  await page.mouse.move(name.x + 65, name.y + 25, {steps: 3});
  await page.mouse.up();
  await until(moved, [second.x, second.y]);
  await press('f');
  await until(([x, y]) => Math.hypot(window.feltwire().places[0].x - x, window.feltwire().places[0].y - y) < 0.5, [first.x, first.y]);
  const width = () => page.evaluate(() => document.querySelector('#side').getBoundingClientRect().width);
  const before = await width();
  await page.focus('#split-x');
  await press('ArrowRight');
  assert.equal(await width(), before - 20);
  await page.reload();
  assert.equal(await width(), before - 20);
});

test('16 hands and 1000 bodies are shown', async () => {
  await newServer({hands: 16, bodies: 1000});
  await open();
  await until(() => window.feltwire().bodies === 1000 && window.feltwire().frames > 5 && window.feltwire().hands.length === 16);
  await press('4');  // Its round trip is unknown.
  await until(() => window.feltwire().chosen === 4 && window.feltwire().plotted.points > 5);
  await until(() => /round trip –/.test(document.querySelector('#plots .plot:last-child .legend').textContent));
});
