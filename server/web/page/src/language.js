// The language of the page: the one that the user chose, else the browser's, else English.

import {forGood} from './kept.js';
import {LANGUAGES, TEXTS} from './texts.js';

const KEY = 'feltwire-language';
const TAGS = LANGUAGES.map(([tag]) => tag);

/** @param {string | null} chosen by the user @param {readonly (string | null)[]} wanted the browser's languages, such as de-CH; some browsers name none @returns {string} a tag of LANGUAGES */
export function chooseLanguage(chosen, wanted) {
  if (TAGS.includes(chosen)) return chosen;
  return wanted.map((tag) => String(tag).toLowerCase().split(/[^a-z]/)[0]).find((tag) => TAGS.includes(tag)) ?? TAGS[0];
}

const browser = globalThis.navigator;  // absent where a program reads a recording by these scripts
export const language = chooseLanguage(forGood.get(KEY), browser?.languages ?? [browser?.language]);
const place = TAGS.indexOf(language);

/**
 * @param {string} key of TEXTS @param {Record<string, string | number>} [values] for the names in braces
 * @returns {string} the text in the page's language
 */
export function say(key, values = {}) {
  const text = TEXTS[key]?.[place];
  if (text === undefined) throw new Error(`there is no text ${key}`);
  return text.replace(/\{(\w+)\}/g, (whole, name) => values[name] ?? whole);
}

/** @param {string} key @returns {boolean} whether there is such a text */
export const hasText = (key) => key in TEXTS;

/** Writes the texts of the document, which is made in English. @param {HTMLSelectElement} selector of the language; the page is loaded again in another one */
export function showLanguage(selector) {
  selector.replaceChildren(...LANGUAGES.map(([tag, name]) => new Option(name, tag, false, tag === language)));
  for (const option of selector.options) option.lang = option.value;
  selector.onchange = () => {
    forGood.set(KEY, selector.value);
    location.reload();
  };
  if (language === TAGS[0]) return;
  document.documentElement.lang = language;
  for (const root of [document, ...[...document.querySelectorAll('template')].map(({content}) => content)]) {
    for (const element of root.querySelectorAll('[data-text]')) element.textContent = say(element.dataset.text);
    for (const element of root.querySelectorAll('[data-title]')) element.title = say(element.dataset.title);
    for (const element of root.querySelectorAll('[data-label]')) element.ariaLabel = say(element.dataset.label);
  }
}
