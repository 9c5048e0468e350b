// Bundles the page and writes it as C++: node build.mjs OUT_FOLDER. The output is the same whenever the sources are.

import {createHash} from 'node:crypto';
import {mkdirSync, readFileSync, writeFileSync} from 'node:fs';
import {join} from 'node:path';
import {gzipSync} from 'node:zlib';
import {build} from 'esbuild';

const out = process.argv[2];
mkdirSync(out, {recursive: true});

/** @param {string} entry @returns {Promise<Buffer>} one file that needs no other */
async function bundle(entry) {
  const made = await build({
    entryPoints: [entry], bundle: true, minify: true, write: false, format: 'esm', target: ['es2022', 'chrome100', 'firefox100', 'safari15.4'],
    legalComments: 'none', logLevel: 'warning',
  });
  return Buffer.from(made.outputFiles[0].contents);
}

const licenses = ['three', 'uplot'].map((name) => `${name}\n\n${readFileSync(`node_modules/${name}/LICENSE`, 'utf8')}`);
const assets = [
  ['/', 'text/html; charset=utf-8', readFileSync('index.html')],
  ['/app.js', 'text/javascript; charset=utf-8', await bundle('src/main.js')],
  ['/style.css', 'text/css; charset=utf-8', await bundle('style.css')],
  ['/icon.svg', 'image/svg+xml', readFileSync('icon.svg')],
  ['/licenses.txt', 'text/plain; charset=utf-8', Buffer.from(licenses.join('\n\n'))],
].map(([path, type, content]) => {
  const gzip = gzipSync(content, {level: 9});  // node writes no time stamp
  return {path, type, gzip, sha256: createHash('sha256').update(content).digest('hex')};
});

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
// The same for tests without a server.
for (const {path, gzip} of assets) writeFileSync(join(out, `${path === '/' ? 'index.html' : path.slice(1)}.gz`), gzip);
writeFileSync(join(out, 'assets.json'), JSON.stringify(assets.map(({path, type, gzip}) => ({path, type, bytes: gzip.length})), null, 1));
