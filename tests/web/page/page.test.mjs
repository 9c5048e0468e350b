// The live page in a browser: connection, words, tables and knobs. Every wait is for a condition.

import assert from 'node:assert/strict';
import {test} from 'node:test';
import {bits, REASONS} from './members.mjs';
import {ADMIN, TOKEN} from './mock_server.mjs';
import {forgive, hold, newPage, newServer, open, page, pixels, press, server, startAnotherServer, state, until} from './page_fixture.mjs';

test('the first picture comes, and the token leaves the address', async () => {
  await open();
  await until(() => window.feltwire().pictures > 5 && window.feltwire().frames > 2);
  assert.equal(await page.textContent('#state span'), 'Live');
  assert.equal(new URL(page.url()).hash, '');
  assert.deepEqual((await state()).hands, [1, 2]);
  assert.equal((await state()).bodies, 1);
  assert.ok(server.requests.every((path) => !path.includes(TOKEN)));
  await page.reload();  // The token is remembered for the session.
  await until(() => window.feltwire().pictures > 0);
});

test('the strip says why', async () => {
  await open();
  await until(() => [...document.querySelectorAll('#reasons li')].some((item) => !item.hidden && /cannot give so much force/.test(item.textContent)));
  await until(() => /The scene asks for .* N, and the device renders .* N/.test(document.querySelector('#sentence').textContent));
  await until(() => /touches nothing/.test(document.querySelector('#sentence').textContent));
});

test('the strip has every reason of the server, and no other', async () => {
  const shown = (reasons) => until((wanted) => {
    const items = [...document.querySelectorAll('#reasons li')].filter((item) => !item.hidden);
    return wanted === JSON.stringify(items.map((item) => item.querySelector('span').textContent));
  }, JSON.stringify([...reasons].sort((a, b) => b.cuts - a.cuts).map(({text}) => text)));  // Those that take force off come first.
  server.play.reasons = 0;
  await open();
  await until(() => window.feltwire().pictures > 3);
  for (const names of [['waiting'], ['account', 'debt'], ['bound', 'shaping'], ['limits', 'ramp'], ['limits', 'wait_for_small_force'], ['gap', 'recovering'],
    ['faded', 'reconnecting'], ['clutched'], ['not_ready'], ['emergency'], ['ending']]) {
    server.play.reasons = bits(...names);
    await shown(names.map((name) => REASONS.findLast((reason) => reason.name === name)));
  }
  await until(() => document.querySelector('tbody tr td:nth-child(5)').textContent === 'ending');
  server.play.reasons = REASONS.reduce((all, _, bit) => all | 1 << bit, 0);
  await shown(REASONS);
});

test('the strip says what an account is short of, and what a shaping counts on', async () => {
  server.play.balance = 0.004;
  await open();
  await press('1');
  await until(() => /Its shaping counts on 1.50 N s\/m of the hand itself/.test(document.querySelector('#sentence').textContent));
  await until(() => !/short of/.test(document.querySelector('#sentence').textContent));
  server.play.balance = -0.0032;
  await until(() => /Its account is short of 3.20 mJ/.test(document.querySelector('#sentence').textContent));
  await press('2');
  await until(() => document.querySelector('#chosen').textContent.includes('bob') && !/shaping counts on/.test(document.querySelector('#sentence').textContent));
});

test('a refused token is said in words, and another can be given', async () => {
  await open('wrong');
  await page.locator('#token').waitFor({state: 'visible'});
  await until(() => document.querySelector('#token-words').textContent.includes('refused'));
  assert.equal(await page.textContent('#token-words'), 'The server refused the token. (unknown token)');
  await page.fill('#token-text', TOKEN);
  await page.click('#token button');
  await until(() => window.feltwire().connection === 'live' && !document.querySelector('#token').open);
});

test('without a token the page asks for one', async () => {
  await page.goto(server.url);
  await page.locator('#token').waitFor({state: 'visible'});
  assert.ok(!server.requests.includes('/live'));
});

test('the page connects again after a server stopped', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  const {port} = server;
  await server.stop();
  await until(() => window.feltwire().connection === 'waiting');
  await until(() => /does not answer.*Next attempt in \d+ s/.test(document.querySelector('#state span').textContent));
  await startAnotherServer({port});
  const {pictures} = await state();
  await page.click('#retry', {timeout: 1000}).catch(() => {});  // It may have connected by itself.
  await until((before) => window.feltwire().connection === 'live' && window.feltwire().pictures > before + 3, pictures);
});

test('a viewer too many is told, and tries again', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  server.drop(4429, '8 viewers');
  await until(() => /as many viewers as it allows. \(8 viewers\)/.test(document.querySelector('#state span').textContent));
  await until(() => window.feltwire().connection === 'live');
});

/** Has the browser say so of its language. */
const speak = (tag) => page.addInitScript((language) => {
  for (const [name, value] of [['language', language], ['languages', [language]]]) Object.defineProperty(navigator, name, {get: () => value});
}, tag);

for (const tag of ['en-US@posix', 'C', 'C.UTF-8', 'de_DE.UTF-8', '', 'x'.repeat(1000), null]) {
  test(`it works where the browser's language is ${JSON.stringify(tag).slice(0, 20)}`, async () => {
    await speak(tag);
    await open();
    await until(() => window.feltwire().pictures > 3 && window.feltwire().plotted.points > 3);
    assert.equal(await page.textContent('#state span'), 'Live');
    await press('h');
    await until(() => document.querySelectorAll('#times tr').length > 2);
  });
}

test('it works where the browser keeps nothing for pages', async () => {
  await page.addInitScript(() => {
    for (const storage of ['localStorage', 'sessionStorage']) {
      Object.defineProperty(window, storage, {get: () => {
        throw new DOMException('The document is sandboxed', 'SecurityError');
      }});
    }
  });
  await open();
  await until(() => window.feltwire().pictures > 3);
  const before = await page.evaluate(() => document.documentElement.dataset.theme);
  await page.click('#theme');
  await until((theme) => document.documentElement.dataset.theme !== theme, before);
  assert.equal(await page.textContent('#state span'), 'Live');
});

test('an exception while it loads is told in the page', async () => {
  await page.addInitScript(() => delete window.ResizeObserver);
  await open();
  await until(() => /^This page could not start: .*ResizeObserver is not defined\. Reload it/.test(document.querySelector('#state span').textContent));
  assert.equal(await page.getAttribute('#state', 'data-state'), 'failed');
  forgive(/ResizeObserver/);
});

test('a browser without WebGL is told so', async () => {
  await page.addInitScript(() => (HTMLCanvasElement.prototype.getContext = () => null));
  await open();
  await until(() => document.querySelector('#state').dataset.state === 'failed');
  assert.equal(await page.textContent('#state span'), 'This browser gives no WebGL 2, without which nothing can be drawn.');
  forgive(/WebGL/);
});

test('an exception before the first script has run is told, too', async () => {
  await page.addInitScript(() => { history.replaceState = () => { throw new Error('history is locked'); }; });
  await open();
  await until(() => /^This page could not start: .*history is locked\./.test(document.querySelector('#state span').textContent));
  forgive(/history is locked/);
});

test('a script that does not come is told', async () => {
  await page.route('**/app.js', (route) => route.abort());
  await open();
  await until(() => /^This page could not start: .*\/app\.js did not come\./.test(document.querySelector('#state span').textContent));
  forgive(/ERR_FAILED/);
});

test('an exception after it has started is told beside the picture', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  assert.ok(await page.locator('#log').isHidden());
  await page.evaluate(() => setTimeout(() => { throw new Error('a knob broke'); }));
  await page.locator('#log').waitFor({state: 'visible'});
  assert.match(await page.textContent('#log span'), /^Something went wrong in this page, and .*: .*a knob broke\. Reload it\.$/);
  forgive(/a knob broke/);
});

test('another scene, a reload, and a message of the log', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  await page.selectOption('#scenes', 'other');
  await until(() => window.feltwire().scene === 'other' && window.feltwire().bodies === 1);
  assert.deepEqual(server.watched, ['other']);
  server.log('error', 'scene.json:12: "stifness" is no field');
  await page.locator('#log').waitFor({state: 'visible'});
  assert.match(await page.textContent('#log span'), /scene.json:12/);
});

test('an admin turns knobs, and is told what is refused', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  const said = () => page.textContent('#admin-said');
  const asked = (count) => until(() => true).then(async () => {
    for (let tries = 0; server.asked.length < count && tries < 600; ++tries) await page.evaluate(() => new Promise(requestAnimationFrame));
    return server.asked.at(-1);
  });
  await page.click('#admin-open');
  await page.fill('#admin input[type=password]', 'wrong');
  await page.click('#admin form button');
  await until(() => document.querySelector('#admin-said').dataset.level === 'error');
  assert.match(await said(), /not good/);
  const stiffness = page.getByLabel(/^Stiffness ?N\/m$/);
  assert.equal(await stiffness.inputValue(), '1000');
  assert.ok(await stiffness.isDisabled());  // An observer sees what it is, and has no knob.
  await page.fill('#admin input[type=password]', ADMIN);
  await page.click('#admin form button');
  await until(() => !document.querySelector('#admin fieldset').disabled);
  await stiffness.fill('250');
  await stiffness.press('Enter');
  assert.deepEqual((await asked(1)).set, {object: await page.locator('#admin select').first().inputValue(), stiffness: 250});
  await until(() => document.querySelector('#admin-said').textContent === 'changed');
  await stiffness.fill('2e9');
  await stiffness.press('Enter');
  await until(() => /at most/.test(document.querySelector('#admin-said').textContent));
  await until(() => document.querySelector('#admin input[type=number]').value === '250');
  const slider = page.locator('#admin input[type=range]');
  await slider.focus();
  await press('Home');
  assert.deepEqual((await asked(3)).set.stiffness, 10);
  await page.click('#admin-hand-tab');
  await page.locator('tbody tr', {hasText: 'alice'}).click();
  await until(() => document.querySelector('#admin select[aria-label="Mode of the bound"]').disabled);
  await page.locator('tbody tr', {hasText: 'bob'}).click();
  await until(() => !document.querySelector('#admin select[aria-label="Mode of the bound"]').disabled);
  await page.selectOption('#admin select[aria-label="Mode of the bound"]', 'per_axis');
  assert.deepEqual((await asked(4)).set, {session: '4712', mode: 'per_axis'});
  await page.getByRole('button', {name: 'Evict'}).click();
  assert.deepEqual(await asked(5), {evict: '4712'});
  await page.click('#admin-scene-tab');
  await page.getByRole('button', {name: /Reload/}).click();
  assert.deepEqual(await asked(6), {reload: true});
  await page.getByRole('button', {name: 'Write a flight record'}).click();
  assert.deepEqual(await asked(7), {record: true});
  await until(() => document.querySelector('#admin-said').textContent.includes('/var/flights/flight-1-room.mcap'));
  assert.ok(server.requests.every((path) => !path.includes(ADMIN)));
});

test('a page that only observes shows the values, and says who can change them', async () => {
  server.play.observes = true;
  await open();
  await until(() => window.feltwire().pictures > 3);
  await page.click('#admin-open');
  assert.match(await page.textContent('#admin-said'), /only observes/);
  assert.ok(!await page.locator('#admin input[type=password]').isVisible());
  await page.click('#admin-scene-tab');
  assert.ok(await page.getByRole('button', {name: 'Write a flight record'}).isDisabled());
  assert.equal(await page.getByLabel(/^Stiffness ?N\/m$/).inputValue(), '1000');
  await page.locator('tbody tr', {hasText: 'bob'}).click();
  await until(() => document.querySelector('#admin select[aria-label="Mode of the bound"]').value === 'contact_frame');
});

test('an admin changes the law, the link and the lead of a client that takes them', async () => {
  await newServer({hands: 3});
  await open();
  await until(() => window.feltwire().pictures > 3);
  const asked = async (count) => {
    for (let tries = 0; server.asked.length < count && tries < 600; ++tries) await page.evaluate(() => new Promise(requestAnimationFrame));
    return server.asked.at(-1).set;
  };
  await page.click('#admin-open');
  await page.fill('#admin input[type=password]', ADMIN);
  await page.click('#admin form button');
  await page.click('#admin-hand-tab');
  await page.locator('tbody tr', {hasText: 'alice'}).click();  // It takes nothing.
  const delay = page.getByLabel(/^Delay ?ms$/);
  await until(() => document.querySelector('#admin select[aria-label="Mode of the bound"]').disabled);
  assert.ok(!await delay.isVisible());
  await page.locator('tbody tr', {hasText: 'carol'}).click();
  await until(() => !document.querySelector('#admin select[aria-label="Mode of the bound"]').disabled);
  await until(() => /has refused: mode shaped -> none/.test(document.querySelector('#admin .answer').textContent));
  await page.selectOption('#admin select[aria-label="Storage of contact_frame"]', 'elastic');
  assert.deepEqual(await asked(1), {session: '4713', storage: 'elastic'});
  await delay.fill('25');
  await delay.press('Enter');
  assert.deepEqual(await asked(2), {session: '4713', link_delay: 0.025, link_jitter: 0, link_loss: 0});
  await page.getByLabel(/^Loss ?%$/).fill('10');
  await page.getByLabel(/^Loss ?%$/).press('Enter');
  assert.deepEqual(await asked(3), {session: '4713', link_delay: 0.025, link_jitter: 0, link_loss: 0.1});
  const share = page.getByLabel(/^Share/);
  assert.equal(await share.inputValue(), '0.5');
  await share.fill('2');
  await share.press('Enter');
  assert.deepEqual(await asked(4), {session: '4713', lead_share: 2});
  await page.locator('tbody tr', {hasText: 'alice'}).click();  // She leads no robot.
  await share.waitFor({state: 'hidden'});
  if (process.env.FELTWIRE_SCREENSHOT) await page.screenshot({path: process.env.FELTWIRE_SCREENSHOT});
});

test('an admin changes friction, gravity and the numbers of a bound', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  const asked = async (count) => {
    for (let tries = 0; server.asked.length < count && tries < 600; ++tries) await page.evaluate(() => new Promise(requestAnimationFrame));
    return server.asked.at(-1).set;
  };
  const give = async (label, value) => {
    await page.getByLabel(label).fill(value);
    await page.getByLabel(label).press('Enter');
  };
  await page.click('#admin-open');
  await page.fill('#admin input[type=password]', ADMIN);
  await page.click('#admin form button');
  const object = await page.locator('#admin select').first().inputValue();
  await give(/^Viscous friction/, '2');
  assert.deepEqual(await asked(1), {object, viscous_friction: 2});
  await give(/^Static friction/, '0.7');
  assert.deepEqual(await asked(2), {object, static_friction: 0.7});
  await until(() => document.querySelector('#admin-said').textContent === 'changed');
  await give(/^Static friction/, '0.3');  // Below the dynamic one, which goes along.
  assert.deepEqual(await asked(3), {object, static_friction: 0.3, dynamic_friction: 0.3});
  await until(() => [...document.querySelectorAll('#admin input[type=number]')].filter((input) => input.value === '0.3').length === 2);
  await page.click('#admin-scene-tab');
  await give('Gravity z', '-1.62');
  assert.deepEqual(await asked(4), {gravity: [0, 0, -1.62]});
  await page.locator('tbody tr', {hasText: 'alice'}).click();  // Her client bounds.
  await page.click('#admin-hand-tab');
  await page.locator('#admin summary').click();
  await page.getByLabel(/^Velocity/).waitFor({state: 'visible'});
  await page.getByLabel(/^c1/).waitFor({state: 'hidden'});
  await page.locator('tbody tr', {hasText: 'bob'}).click();
  await page.getByLabel(/^c1/).waitFor({state: 'visible'});
  await page.getByLabel('Reference of passivity_control').selectOption('following');
  assert.deepEqual(await asked(5), {session: '4712', reference: 'following'});
  const numbers = {operator_damping: /^Operator/, velocity_cutoff: /^Velocity/, c1: /^c1/, c2: /^c2/, coupling_stiffness: /^Coupling s/, coupling_damping: /^Coupling d/, tool_mass: /^Mass of/};
  let count = 5;
  for (const [field, label] of Object.entries(numbers)) {
    await give(label, '0.5');
    assert.deepEqual(await asked(count += 1), {session: '4712', [field]: 0.5});
  }
});

test('hostile bytes are ignored', async () => {
  await open();
  await until(() => window.feltwire().pictures > 3);
  const cut = server.play.picture().subarray(0, 60);
  const wild = Buffer.alloc(24);
  wild.writeUInt32LE(2, 0);
  wild.writeUInt32LE(0xffffffff, 4);
  for (const bytes of [cut, wild, Buffer.alloc(0), Buffer.from([1, 0, 0, 0]), Buffer.from([77, 1]), Buffer.from([3, 0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255])]) server.send(bytes);
  server.log('info', '<img src=x>');
  await until(() => window.feltwire().unread === 3);
  assert.equal(await page.locator('#log img').count(), 0);
  const {pictures} = await state();
  await until((before) => window.feltwire().pictures > before + 3, pictures);
});

test('keys are listed, the theme changes, and no panel leaves a phone', async () => {
  await open();
  await until(() => window.feltwire().frames > 2);
  await press('?');
  await page.locator('#help').waitFor({state: 'visible'});
  assert.ok(await page.locator('#keys dt').count() > 10);
  await press('Escape');
  const light = await pixels('view');
  assert.ok(light > 1000);
  await press('l');
  await until(() => document.documentElement.dataset.theme === 'dark');
  await newPage({viewport: {width: 390, height: 800}, isMobile: true, hasTouch: true});
  await open();
  await until(() => window.feltwire().frames > 2);
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
});

test('on a phone every button can be tapped', async () => {
  await newPage({viewport: {width: 390, height: 800}, isMobile: true, hasTouch: true});
  await open();
  await until(() => window.feltwire().pictures > 3 && window.feltwire().trails.length === 2 && window.feltwire().surfaces > 0);
  await page.tap('#trails');
  await until(() => window.feltwire().trails.length === 0);
  assert.equal(await page.getAttribute('#trails', 'aria-pressed'), 'false');
  await page.tap('#surfaces');
  await until(() => window.feltwire().surfaces === 0);
  await page.tap('#next');
  await until(() => window.feltwire().chosen === 2);
  await page.tap('#hold');
  await until(() => window.feltwire().held);
  const {places: [, bob]} = await state();
  await page.tap('#follow');  // The hand is in the middle of the view then.
  await until(([x, y]) => Math.hypot(window.feltwire().places[1].x - x, window.feltwire().places[1].y - y) > 1, [bob.x, bob.y]);
  await until(() => {
    const {width, height} = document.querySelector('#canvas').getBoundingClientRect();
    return Math.hypot(window.feltwire().places[1].x - width / 2, window.feltwire().places[1].y - height / 2) < 1;
  });
  await page.tap('#see-all');
  await until(([x, y]) => Math.hypot(window.feltwire().places[1].x - x, window.feltwire().places[1].y - y) < 1, [bob.x, bob.y]);
  await page.tap('#arrow-more');
  await page.tap('#times-open');
  await until(() => document.querySelectorAll('#times tr').length > 2);
  await page.tap('#times button');
  await page.tap('#help-open');
  await page.locator('#help').waitFor({state: 'visible'});
  await page.tap('#help form button');
  await page.tap('#admin-open');
  await page.locator('#admin').waitFor({state: 'visible'});
  await page.tap('tbody tr:first-child');
  await until(() => window.feltwire().chosen === 1);
  const small = await page.evaluate(() => [...document.querySelectorAll('body > header button, #scales button, #side header button')].filter((button) => {
    const {width, height, left, right} = button.getBoundingClientRect();
    return width > 0 && (height < 24 || width < 24 || left < 0 || right > innerWidth);
  }).map(({id}) => id));
  assert.deepEqual(small, []);
});
