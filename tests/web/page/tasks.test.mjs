// Five tasks of a new user on the page of a real server, by the names of what is seen alone: no key, no identifier, no link. Each prints how
// long a script needs and how many acts it makes. FELTWIRE_PROGRAMS: the folder of the programs. FELTWIRE_TOUR_SCENE: a scene, which stands beside room.json.

import assert from 'node:assert/strict';
import {spawn} from 'node:child_process';
import {dirname, join} from 'node:path';
import {test} from 'node:test';
import {control, open, ownToken, serve, state} from './real_server.mjs';

/** Counts what a user does. @param {import('playwright-core').Page} page */
function hands(page) {
  let acts = 0;
  const act = (done) => {
    acts += 1;
    return done;
  };
  const button = (name) => page.getByRole('button', {name, exact: typeof name === 'string'}).and(page.locator(':visible'));
  return {
    get acts() {
      return acts;
    },
    press: (name) => act(button(name).first().click()),
    row: (name) => act(page.getByRole('row').filter({hasText: name}).click()),
    choose: (name, value) => act(page.getByRole('combobox', {name, exact: true}).selectOption(value)),
    write: async (name, value) => {
      const input = page.getByLabel(name).and(page.locator('input[type=number]:visible')).first();
      await act(input.fill(value));
      await act(input.press('Enter'));
    },
    read: (pattern) => page.getByText(pattern).and(page.locator(':visible')).first().waitFor(),
  };
}

test('five tasks of a new user', async (context) => {
  await serve(join(dirname(process.env.FELTWIRE_TOUR_SCENE), 'room.json'), '--demo');
  const client = spawn(join(process.env.FELTWIRE_PROGRAMS, 'feltwire-client'), ['--connect', `127.0.0.1:${control}`, '--fingerprint-file', join(state, 'fingerprint'),
    '--token-file', join(state, 'local.token'), '--scene', 'room', '--name', 'weak', '--device', 'simulated:path=press,depth=0.01', '--max-force', '0.05', '--duration', '600'], {stdio: 'ignore'});
  context.after(() => client.kill());
  const page = await open(ownToken('admin'), {viewport: {width: 1360, height: 860}});
  await page.waitForFunction(() => window.feltwire().hands.length === 3 && document.querySelectorAll('#sessions tbody tr').length === 3);

  const tasks = [
    ['find why hand 3 feels nothing', async (user) => {
      await user.row('weak');
      await user.read(/The scene asks for [\d.]+ N, and the device renders 0\.0\d N/);
      await user.read(/\blimits\b.*safety limit/);
    }],
    ['make the table twice as stiff', async (user) => {
      await user.press('Admin');
      await user.choose('Object', 'table');
      await user.write(/^Stiffness/, '1800');
      await page.waitForFunction(() => /table.*stiffness.*1800/.test(document.querySelector('#admin-said').textContent));
      await user.press('Admin');
    }],
    ['compare the forces of two hands', async (user) => {
      await user.press(/^Compare/);
      await page.waitForFunction(() => [...document.querySelectorAll('#plots section:first-child .legend span')].filter((line) => /(left|right)-hand [\d.]+ N/.test(line.textContent)).length === 2);
      await user.press(/^Compare/);
    }],
    ['take a hand and choose its law', async (user) => {
      await user.choose('Law', 'per_axis');
      await user.press('Take a hand');
      await user.read(/^You hold a hand/);
      await page.getByRole('row').filter({hasText: 'per_axis'}).waitFor();
      await user.press('Let go');
    }],
    ['record 10 s and open them', async (user) => {
      await user.press('Record');
      await page.getByRole('button', {name: /^Stop 1\d s/}).waitFor();
      await user.press(/^Stop/);
      await user.press('Open');
      await page.waitForFunction(() => {
        const {stages} = window.feltwire().replay;
        return stages.length === 1 && stages[0].whole && stages[0].duration >= 9 && stages[0].solids > 0;
      });
    }],
  ];
  for (const [name, task] of tasks) {
    const user = hands(page);
    const begun = performance.now();
    await task(user);
    context.diagnostic(`${name}: ${((performance.now() - begun) / 1000).toFixed(1)} s, ${user.acts} act(s)`);
    assert.ok(user.acts > 0);
  }
});
