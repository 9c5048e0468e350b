// Elements of the page that scripts make.

/** @param {string} tag @param {object} properties @param {...(Node | string)} children */
export function make(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/**
 * Tabs, of which one page is shown. The arrow keys go from tab to tab.
 * @param {string} id the elements' ids begin with it @param {Record<string, (Node | string)[]>} contents of each page, by the end of its id
 * @param {(name: string) => string} title of a tab
 * @returns {{tabs: HTMLElement, pages: HTMLElement[]}}
 */
export function makeTabs(id, contents, title) {
  const names = Object.keys(contents);
  const ids = names.map((name) => `${id}-${name}`);
  const pages = names.map((name, i) => make('div', {id: ids[i], role: 'tabpanel', ariaLabel: title(name)}, ...contents[name]));
  const buttons = names.map((name, i) => make('button', {id: `${ids[i]}-tab`, role: 'tab', onclick: () => show(i)}, title(name)));
  const show = (shown) => buttons.forEach((button, i) => {
    pages[i].hidden = i !== shown;
    button.ariaSelected = String(i === shown);
    button.tabIndex = i === shown ? 0 : -1;
  });
  buttons.forEach((button, i) => button.setAttribute('aria-controls', ids[i]));
  const tabs = make('div', {role: 'tablist', className: 'tabs'}, ...buttons);
  tabs.onkeydown = (event) => {
    const step = {ArrowLeft: -1, ArrowRight: 1}[event.key];
    if (!step) return;
    event.stopPropagation();
    event.preventDefault();
    const next = (buttons.indexOf(document.activeElement) + step + buttons.length) % buttons.length;
    show(next);
    buttons[next].focus();
  };
  show(0);
  return {tabs, pages};
}
