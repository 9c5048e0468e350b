// Bundles the page and writes it as C++: node build.mjs OUT_FOLDER. The output is the same whenever the sources are.

import {createHash} from 'node:crypto';
import {mkdirSync, readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {gzipSync} from 'node:zlib';
import {build} from 'esbuild';
import {LANGUAGES, TEXTS} from './src/texts.js';

const out = process.argv[2];
mkdirSync(out, {recursive: true});

/**
 * uPlot asks for numbers in the browser's language, and throws where that is none, such as "en-US@posix". Its authors have mended that,
 * in no release yet. Numbers of the page are the same in all its languages.
 */
const englishPlots = {
  name: 'english-plots',
  setup: ({onLoad}) => onLoad({filter: /uPlot\.esm\.js$/}, ({path}) => {
    const language = "domEnv ? nav.language : 'en-US'";
    const parts = readFileSync(path, 'utf8').split(language);
    if (parts.length !== 2) throw new Error(`uPlot has not once: ${language}`);
    return {contents: parts.join("'en-US'"), loader: 'js'};
  }),
};

/** @param {string} entry @param {string[]} [external] files that stay files of their own @returns {Promise<Buffer>} one file with all others in it */
async function bundle(entry, external = []) {
  const made = await build({
    entryPoints: [entry], bundle: true, minify: true, write: false, format: 'esm', target: ['es2022', 'chrome100', 'firefox100', 'safari15.4'],
    legalComments: 'none', logLevel: 'warning', external, plugins: [englishPlots],
  });
  return Buffer.from(made.outputFiles[0].contents);
}

const licenses = ['fzstd', 'three', 'uplot'].map((name) => `${name}\n\n${readFileSync(`node_modules/${name}/LICENSE`, 'utf8')}`);
const text = (content) => content.toString('utf8');
const page = inEnglish(text(readFileSync('index.html')));
const trouble = withTexts(text(readFileSync('src/trouble.js')));  // Else as it is: also an old browser reads it.
const early = await bundle('src/early.js');
const script = await bundle('src/main.js', ['./early.js']);
const wholeScript = text(await bundle('src/main.js'));
const style = text(await bundle('style.css'));
const assets = [
  ['/', 'text/html; charset=utf-8', Buffer.from(page)],
  ['/replay', 'text/html; charset=utf-8', Buffer.from(page)],  // The same page, which asks for no token there.
  ['/trouble.js', 'text/javascript; charset=utf-8', Buffer.from(trouble)],
  ['/early.js', 'text/javascript; charset=utf-8', early],
  ['/app.js', 'text/javascript; charset=utf-8', script],
  ['/style.css', 'text/css; charset=utf-8', Buffer.from(style)],
  ['/icon.svg', 'image/svg+xml', readFileSync('icon.svg')],
  ['/licenses.txt', 'text/plain; charset=utf-8', Buffer.from(licenses.join('\n\n'))],
].map(([path, type, content]) => {
  const gzip = gzipSync(content, {level: 9});  // node writes no time stamp
  return {path, type, gzip, sha256: createHash('sha256').update(content).digest('hex')};
});

// The page's size as a browser loads it: content with two names is loaded once.
const MOST = 300_000;  // [bytes]
const whole = assets.filter(({path}) => path !== '/replay').reduce((sum, {gzip}) => sum + gzip.length, 0);
if (whole > MOST) throw new Error(`the page has ${whole} bytes compressed, and may have ${MOST}`);

const arrays = assets.map(({gzip}, i) => `constexpr unsigned char bytes_${i}[] = {${[...gzip].join(',')}};`);
const rows = assets.map(({path, type, sha256}, i) => `    {"${path}", "${type}", "${sha256}", bytes_${i}},`);
writeFileSync(join(out, 'page_assets.cpp'), `// Written by server/web/page/build.mjs.
#include "server/web/page_assets.hpp"

namespace feltwire {
namespace {

${arrays.join('\n')}

constexpr PageAsset assets[] = {
${rows.join('\n')}
};

}  // namespace

std::span<const PageAsset> page_assets() noexcept { return assets; }

}  // namespace feltwire
`);
writeFileSync(join(out, 'feltwire-replay.html'), wholePage());
// Also write the files, for tests without a server.
for (const {path, gzip} of assets) writeFileSync(join(out, `${path === '/' ? 'index.html' : path.slice(1)}.gz`), gzip);
writeFileSync(join(out, 'assets.json'), JSON.stringify(assets.map(({path, type, gzip}) => ({path, type, bytes: gzip.length})), null, 1));

/** The page with its English texts, which are there before any script. @param {string} html whose elements name their texts */
function inEnglish(html) {
  const english = (key) => {
    if (!TEXTS[key]) throw new Error(`index.html names a text that is not there: ${key}`);
    return TEXTS[key][0].replaceAll('&', '&amp;').replaceAll('<', '&lt;').replaceAll('"', '&quot;');
  };
  return html.replace(/ data-(title|label)="([^"]+)"/g, (whole, name, key) => `${whole} ${name === 'title' ? 'title' : 'aria-label'}="${english(key)}"`)
    .replace(/ data-text="([^"]+)"[^<>]*>/g, (whole, key) => whole + english(key));
}

/** @param {string} script that says something before the others are there @returns {string} it has its texts in all languages */
function withTexts(script) {
  const keys = ['app.failed', 'app.wrong', 'app.missing', 'app.nameless'];
  const texts = Object.fromEntries(LANGUAGES.map(([tag], place) => [tag, Object.fromEntries(keys.map((key) => [key, TEXTS[key][place]]))]));
  const parts = script.split("'TEXTS'");
  if (parts.length !== 2) throw new Error("trouble.js has not once: 'TEXTS'");
  return parts.join(JSON.stringify(texts));
}

/** The page as one file, which a browser opens without any server. Its policy allows its own script and style, and no connection. */
function wholePage() {
  const inner = wholeScript.replaceAll('</script', '<\\/script');
  const first = trouble;
  const hash = (content) => `'sha256-${createHash('sha256').update(content).digest('base64')}'`;
  const policy = `default-src 'none'; script-src ${hash(first)} ${hash(inner)}; style-src ${hash(style)}; img-src data:; base-uri 'none'; form-action 'none'`;
  const icon = `data:image/svg+xml;base64,${readFileSync('icon.svg').toString('base64')}`;
  const escaped = licenses.join('\n\n').replaceAll('&', '&amp;').replaceAll('<', '&lt;');
  const parts = [
    ['<meta charset="utf-8">', `<meta charset="utf-8">\n<meta http-equiv="Content-Security-Policy" content="${policy}">`],
    ['<link rel="icon" href="icon.svg">', `<link rel="icon" href="${icon}">`],
    ['<link rel="stylesheet" href="style.css">', `<style>${style}</style>`],
    ['<script src="trouble.js" defer></script>', `<script>${first}</script>`],
    ['<script type="module" src="early.js"></script>\n<script type="module" src="app.js"></script>', `<script type="module">${inner}</script>`],
    ['<a href="licenses.txt" target="_blank" rel="noopener" data-text="help.licences">Licences</a>', `<details><summary data-text="help.licences">Licences</summary><pre>${escaped}</pre></details>`],
  ];
  let whole = page;
  for (const [from, to] of parts) {
    if (whole.split(from).length !== 2) throw new Error(`index.html has not once: ${from}`);
    whole = whole.replace(from, () => to);
  }
  return whole;
}
