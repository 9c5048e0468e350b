// How much the page costs with 16 hands and 1000 bodies: node measure_page.mjs PAGE_FOLDER [HANDS [BODIES [SECONDS [SCALE]]]]
// PAGE_FOLDER is the folder page/out that run-page-tests has made. The calls of WebGL that draw are counted and left out, so that a
// machine without a graphics card draws nothing and the page has its usual rate. All other calls run. Prints the pictures that
// came, the frames, the draw calls of a frame, and the time in the page's own script: what a graphics card does not change. SCALE
// is the number of pixels to a CSS pixel, each way: without a graphics card the processor puts them together for each frame.

import {chromium} from 'playwright-core';
import {startServer, TOKEN} from './mock_server.mjs';

const PATIENCE = 120_000;  // [ms]
const WARM = 240;  // frames after which the browser has compiled the script
const [folder, hands = '16', bodies = '1000', seconds = '10', scale = '1'] = process.argv.slice(2);
if (!folder) {
  console.error('usage: node measure_page.mjs PAGE_FOLDER [HANDS [BODIES [SECONDS [SCALE]]]]');
  process.exit(2);
}

const server = await startServer({folder, hands: Number(hands), bodies: Number(bodies)});
const browser = await chromium.launch({executablePath: process.env.FELTWIRE_CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox']});
try {
  const page = await browser.newPage({viewport: {width: 1360, height: 860}, deviceScaleFactor: Number(scale)});
  page.setDefaultTimeout(PATIENCE);
  await page.addInitScript(() => {
    window.times = [];  // [ms] of each call for a frame
    window.draws = 0;
    const request = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (call) => request((now) => {
      const begin = performance.now();
      call(now);
      window.times.push(performance.now() - begin);
    });
    for (const name of ['drawArrays', 'drawElements', 'drawArraysInstanced', 'drawElementsInstanced', 'drawRangeElements']) {
      WebGL2RenderingContext.prototype[name] = () => (window.draws += 1);
    }
    // The page uses this extension where there is one, and else draws each of its parts with a call.
    const extension = WebGL2RenderingContext.prototype.getExtension;
    WebGL2RenderingContext.prototype.getExtension = function get(name) {
      const found = extension.call(this, name);
      for (const call of ['multiDrawArraysWEBGL', 'multiDrawElementsWEBGL', 'multiDrawElementsInstancedWEBGL']) {
        if (found?.[call]) found[call] = () => (window.draws += 1);
      }
      return found;
    };
  });
  await page.goto(`${server.url}#token=${TOKEN}`);
  await page.waitForFunction(([count, warm]) => window.feltwire?.().bodies === count && window.feltwire().plotted.points > 5 &&
    window.feltwire().frames > warm, [Number(bodies), WARM]);
  const devtools = await page.context().newCDPSession(page);
  await devtools.send('Performance.enable');
  const read = async () => {
    const {metrics} = await devtools.send('Performance.getMetrics');
    const metric = (wanted) => metrics.find(({name}) => name === wanted).value;
    const [state, count, draws] = await page.evaluate(() => [window.feltwire(), window.times.length, window.draws]);
    return {script: metric('ScriptDuration'), layout: metric('LayoutDuration') + metric('RecalcStyleDuration'), at: performance.now(),
      frames: state.frames, pictures: state.pictures, count, draws};
  };
  const from = await read();
  await page.waitForTimeout(1000 * Number(seconds));
  const to = await read();
  const elapsed = (to.at - from.at) / 1000;
  const times = (await page.evaluate(() => window.times)).slice(from.count, to.count).sort((a, b) => a - b);
  const quantile = (share) => times[Math.min(times.length - 1, Math.floor(share * times.length))].toFixed(1);
  const frames = to.frames - from.frames;
  const each = (member) => ((1000 * (to[member] - from[member])) / frames).toFixed(2);
  console.log(`${hands} hands, ${bodies} bodies, ${elapsed.toFixed(1)} s: ${((to.pictures - from.pictures) / elapsed).toFixed(1)} pictures/s came, ` +
    `${(frames / elapsed).toFixed(1)} frames/s, ${((to.draws - from.draws) / frames).toFixed(0)} draw calls a frame`);
  console.log(`call for a frame: p50 ${quantile(0.5)} ms, p90 ${quantile(0.9)} ms, p99 ${quantile(0.99)} ms; ` +
    `all script: ${each('script')} ms a frame; style and layout: ${each('layout')} ms a frame`);
} finally {
  await browser.close();
  await server.stop();
}
