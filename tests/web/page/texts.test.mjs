// All texts of the page stand in one file, in every language. FELTWIRE_PAGE_SOURCE: the folder of the page's sources.

import assert from 'node:assert/strict';
import {readdirSync, readFileSync} from 'node:fs';
import {join} from 'node:path';
import {test} from 'node:test';
import {pathToFileURL} from 'node:url';
import {REASONS} from './members.mjs';

const folder = process.env.FELTWIRE_PAGE_SOURCE;
const {LANGUAGES, TEXTS} = await import(pathToFileURL(join(folder, 'src/texts.js')));
const page = readFileSync(join(folder, 'index.html'), 'utf8');
const scripts = readdirSync(join(folder, 'src'), {recursive: true}).filter((name) => name.endsWith('.js') && name !== 'texts.js');

/** Strings that look like texts and are none: units, names of keys and commands, programs for the graphics card, code. */
const NONE = [
  /^(Arrow(Left|Right|Up|Down)|Page(Up|Down)|Home|End|Enter|Escape)$/, /^(Authorization|Bearer )/, /^(STATE|LINK|SCRIPT|DOMContentLoaded)$/, /system-ui, sans-serif/, /^(N s\/m|m\/s²|kg)$/,
  /gl_Position|gl_FragColor/, /^mcap compress/, /^the key .* is bound twice$/, /^there is no text /, /^(feltwire \{\}, )?live page$/, /^(File|Uncaught )/, /^utf-8$/,
  /^(input|#sessions) ?[\w ,[\]="()-]*$/, /^\((pointer|prefers|max-width)/, /^translate\(/, /^Hz$/, /^×$/, /^\{\} ×$/, /^feltwire \{\}$/,
];

/**
 * Reads a script as far as strings need it. @param {string} code
 * @returns {{text: string, before: string}[]} the strings and the fixed parts of templates, each with the code before it
 */
function stringsOf(code) {
  const found = [];
  let at = 0;
  const template = () => {  // after its first quote
    let text = '';
    const begin = at;
    while (code[at] !== '`') {
      if (code[at] === '\\') text += code[at++] + code[at++];
      else if (code.startsWith('${', at)) {
        at += 2;
        text += '{}';
        run('}');
      } else text += code[at++];
    }
    at += 1;
    found.push({text, before: code.slice(Math.max(begin - 40, 0), begin - 1)});
  };
  const run = (end) => {
    for (let depth = 0; at < code.length;) {
      const letter = code[at];
      if (letter === end && depth === 0) return void (at += 1);
      if (letter === '{') depth += 1;
      if (letter === '}') depth -= 1;
      if (code.startsWith('//', at)) at = code.indexOf('\n', at);
      else if (code.startsWith('/*', at)) at = code.indexOf('*/', at) + 2;
      else if (letter === '`') {
        at += 1;
        template();
      } else if (letter === "'" || letter === '"') {
        const begin = at;
        for (at += 1; code[at] !== letter; ++at) if (code[at] === '\\') at += 1;
        found.push({text: code.slice(begin + 1, at), before: code.slice(Math.max(begin - 40, 0), begin)});
        at += 1;
      } else if (letter === '/' && /[(,=:[!&|?{};\n]\s*$/.test(code.slice(Math.max(at - 3, 0), at))) {  // a regular expression
        for (at += 1; code[at] !== '/'; ++at) {
          if (code[at] === '\\') at += 1;
          if (code[at] === '[') for (; code[at] !== ']'; ++at) if (code[at] === '\\') at += 1;
        }
        at += 1;
      } else at += 1;
    }
  };
  run(null);
  return found;
}

/** Whether a string is a text for people: two words, a word with a capital letter, letters of another script, or shown by where it stands. */
function isText({text, before}) {
  const plain = text.replaceAll('{}', ' ');
  if (NONE.some((pattern) => pattern.test(text))) return false;
  if (/\b(title|hint|ariaLabel|textContent|placeholder|text|said)( =|:) $/.test(before)) return /[a-z]{2}/i.test(plain);
  return /[a-z]{2,}[,.:;!?]? +[a-z]{2,}/i.test(plain) || /^[A-Z][a-z]+$/.test(plain.trim()) || /[\u00c0-\u024f\u1100-\u11ff\uac00-\ud7af]/.test(plain);
}

test('each text is there in every language, with the same values', () => {
  for (const [key, texts] of Object.entries(TEXTS)) {
    assert.equal(texts.length, LANGUAGES.length, key);
    const values = texts.map((text) => [...text.matchAll(/\{(\w+)\}/g)].map(([, name]) => name).sort().join());
    texts.forEach((text, i) => {
      assert.ok(typeof text === 'string' && text.trim() !== '', `${key}, ${LANGUAGES[i][1]}`);
      assert.equal(values[i], values[0], `${key}, ${LANGUAGES[i][1]}`);
    });
  }
  const korean = Object.entries(TEXTS).filter(([, texts]) => texts[2] === texts[0]).map(([key]) => key);  // names, units and formulas
  assert.ok(korean.length < 0.05 * Object.keys(TEXTS).length, `not translated: ${korean.join(' ')}`);
});

test('each text that is asked for is there, and each that is there is asked for', () => {
  const asked = new Set([...page.matchAll(/data-(?:text|title|label)="([^"]+)"/g)].map(([, key]) => key));
  const patterns = [];  // of keys that are made of values
  for (const name of [...scripts.map((script) => join('src', script)), 'build.mjs']) {
    for (const {text} of stringsOf(readFileSync(join(folder, name), 'utf8'))) {
      if (!/^[a-z]+\.[\w.{}]+$/.test(text)) continue;
      if (!text.includes('{}')) asked.add(text);
      else patterns.push(new RegExp(`^${text.replaceAll('.', '\\.').replaceAll('{}', '[\\w.]+')}$`));
    }
  }
  for (const key of asked) if (!/\.(js|html|css|svg|txt|json|mjs|cpp|hpp|token|v1|min)$/.test(key)) assert.ok(key in TEXTS, `there is no text ${key}`);
  const unasked = Object.keys(TEXTS).filter((key) => !asked.has(key) && !patterns.some((pattern) => pattern.test(key)));
  assert.deepEqual(unasked, [], 'nobody asks for them');
});

test('the page has no text of its own', () => {
  const between = page.replace(/<!doctype[^>]*>/, '').replace(/<(title|option)[^>]*>[^<]*<\/\1>/g, '').replace(/<[^>]*>/g, '\n').split('\n').map((text) => text.trim());
  assert.deepEqual(between.filter((text) => /[a-z]{2}/i.test(text) && !/^(feltwire|CSV|PNG)$/.test(text)), []);
  assert.deepEqual([...page.matchAll(/ (?:title|aria-label|placeholder|alt)="[^"]*"/g)].map(([whole]) => whole), []);
});

test('no style has a text of its own', () => {
  const styles = readdirSync(folder).filter((name) => name.endsWith('.css'));
  assert.ok(styles.length > 0);
  const found = styles.flatMap((name) => [...readFileSync(join(folder, name), 'utf8').matchAll(/content: *(["'])(.*?)\1/g)].map(([, , text]) => `${name}: ${text}`));
  assert.deepEqual(found.filter((text) => /: .*\p{L}/u.test(text)), []);
});

test('no script has a text of its own', () => {
  const found = scripts.flatMap((name) => stringsOf(readFileSync(join(folder, 'src', name), 'utf8')).filter(isText).map(({text}) => `${name}: ${text}`));
  assert.deepEqual(found, []);
});

test('reasons have the texts of the server', () => {
  REASONS.forEach(({name, text}, bit) => {
    const again = REASONS.slice(0, bit).filter((reason) => reason.name === name).length;
    assert.equal(TEXTS[`reason.${name}${again > 0 ? `.${again + 1}` : ''}`]?.[0], text, name);
  });
});
