// The language of the page: the one that the user chose, else the browser's, else English.

import {forGood} from './kept.js';
import {LANGUAGES, TEXTS} from './texts.js';

const KEY = 'feltwire-language';
const TAGS = LANGUAGES.map(([tag]) => tag);

/** @param {string | null} chosen by the user @param {readonly string[]} wanted the browser's languages, such as de-CH @returns {string} a tag of LANGUAGES */
export function chooseLanguage(chosen, wanted) {
  if (TAGS.includes(chosen)) return chosen;
  return wanted.map((tag) => tag.toLowerCase().split('-')[0]).find((tag) => TAGS.includes(tag)) ?? TAGS[0];
}

export const language = chooseLanguage(forGood.get(KEY), navigator.languages ?? []);
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

/** Keeps another language, and loads the page in it. @param {string} tag of LANGUAGES */
export function changeLanguage(tag) {
  forGood.set(KEY, tag);
  location.reload();
}
