// Tests ask this of every page: contrast, names of controls, and that nothing is wider than the window.

import axe from 'axe-core';

const TAGS = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'];

/** @param {import('playwright-core').Page} page @returns {Promise<string[]>} elements whose content is wider than they are, unless it ends in an ellipsis */
export const overflowing = (page) => page.evaluate(() => {
  const name = (element) => element.tagName.toLowerCase() + (element.id ? `#${element.id}` : '') + (element.className ? `.${element.className}` : '');
  const found = document.documentElement.scrollWidth > innerWidth ? [`the page: ${document.documentElement.scrollWidth} of ${innerWidth} px`] : [];
  for (const element of document.body.querySelectorAll('*')) {
    if (!element.checkVisibility() || element.closest('#labels, .drawing, .arrow') || getComputedStyle(element.parentElement).textOverflow === 'ellipsis') continue;  // Their content is drawn, and may end at the edge.
    const style = getComputedStyle(element);
    const {left, right} = element.getBoundingClientRect();
    if (left < -1 || right > innerWidth + 1) found.push(`${name(element)}: from ${Math.round(left)} to ${Math.round(right)} px`);
    const wide = element.clientWidth > 0 && element.scrollWidth > element.clientWidth + 1;
    if (wide && style.textOverflow !== 'ellipsis' && style.display !== 'inline') found.push(`${name(element)}: ${element.scrollWidth} of ${element.clientWidth} px`);
  }
  return found;
});

/** @param {import('playwright-core').Page} page @returns {Promise<string[]>} all that axe-core finds wrong, and each text whose contrast it cannot tell, but for
 *   texts of a letter or a sign */
export async function faults(page) {
  await page.evaluate(() => scrollTo(0, 0));  // Else the header lies over what was scrolled below it.
  await page.evaluate(axe.source);
  return page.evaluate(async (tags) => {
    const {violations, incomplete} = await window.axe.run(document.querySelector('dialog[open]') ?? document, {runOnly: tags, resultTypes: ['violations', 'incomplete']});
    const judged = ({any}) => !['shortTextContent', 'nonBmp'].includes(any[0]?.data?.messageKey);
    const unknown = incomplete.filter(({id}) => id === 'color-contrast').map(({id, nodes}) => ({id, nodes: nodes.filter(judged)}));
    return [...violations, ...unknown].flatMap(({id, nodes}) => nodes.map(({target, any, all, none}) => (
      `${id} ${target.join(' ')}: ${[...any, ...all, ...none][0]?.message ?? ''}`)));
  }, TAGS);
}
