// How long the page takes for a recording, and how much memory: in the work folder of run-replay-tests,
//   node tests/measure_recording.mjs FILE.mcap

import {resolve} from 'node:path';
import {fileURLToPath} from 'node:url';
import {chromium} from 'playwright-core';

const page_file = new URL('../page/out/feltwire-replay.html', import.meta.url);
const browser = await chromium.launch({
  executablePath: process.env.FELTWIRE_CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox', '--enable-precise-memory-info'],
});
const page = await browser.newPage({viewport: {width: 1360, height: 860}});
page.setDefaultTimeout(600_000);
await page.goto(page_file.href);
await page.evaluate(() => {
  document.querySelector('#recording-files').addEventListener('change', () => (window.chosen = performance.now()), true);
  const look = () => {
    const said = document.querySelector('[data-part="sentence"]')?.textContent ?? '';
    if (/The scene asks|It moves freely/.test(said)) window.first = performance.now();
    else requestAnimationFrame(look);
  };
  look();
});
await page.setInputFiles('#recording-files', resolve(process.argv[2]));
await page.waitForFunction(() => window.first && window.feltwire().replay.stages[0].read);
const {first, all, heap, stage} = await page.evaluate(() => ({
  first: window.first - window.chosen, all: performance.now() - window.chosen, heap: performance.memory.usedJSHeapSize, stage: window.feltwire().replay.stages[0],
}));
console.log(`${fileURLToPath(page_file)}: ${stage.duration.toFixed(0)} s of recording; the first moment after ${(first / 1000).toFixed(2)} s, ` +
  `all of the bar after ${(all / 1000).toFixed(1)} s, ${(heap / 2 ** 20).toFixed(0)} MiB of JavaScript's heap`);
await browser.close();
