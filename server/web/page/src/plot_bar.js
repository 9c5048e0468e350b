// The buttons above the plots: time, several hands over each other, and files of what is plotted.

import {say} from './language.js';
import {fileName, save, saveCanvas} from './save.js';

const element = (id) => document.getElementById(id);

export class PlotBar {
  /**
   * @param {import('./live_plots.js').Plots} plots
   * @param {() => {scene: string, chosen: number | null, name: string}} page what is watched
   * @param {() => import('./live_plots.js').Shown[]} hands that may be plotted
   */
  constructor(plots, page, hands) {
    this.plots = plots;
    this.page = page;
    this.hands = hands;
    const acts = {
      'plot-in': () => plots.zoom(1), 'plot-out': () => plots.zoom(-1), 'plot-earlier': () => plots.move(-1), 'plot-later': () => plots.move(1),
      compare: () => this.compare(!plots.comparing), 'plot-csv': () => this.saveValues(), 'plot-png': () => this.saveImage(),
    };
    for (const [id, act] of Object.entries(acts)) element(id).onclick = act;
    element('seconds').onchange = (event) => plots.follow(Number(event.target.value));
  }

  /** Keys of the page that act here. */
  bindings() {
    const {plots} = this;
    return [
      {keys: ['[', ']'], shown: '[ ]', text: say('keys.span'), act: (key) => plots.zoom(key === ']' ? 1 : -1)},
      {keys: ['<', '>'], shown: '< >', text: say('keys.shift'), act: (key) => plots.move(key === '>' ? 1 : -1)},
      {keys: ['m'], text: say('keys.compare'), act: () => this.compare(!plots.comparing)},
      {keys: ['v'], text: say('keys.csv'), act: () => this.saveValues()},
      {keys: ['b'], text: say('keys.png'), act: () => this.saveImage()},
    ];
  }

  /** @param {boolean} comparing */
  compare(comparing) {
    this.plots.comparing = comparing;
    element('compare').setAttribute('aria-pressed', String(comparing));
    this.plots.update(this.hands());
  }

  saveValues() {
    save(new Blob([this.plots.csv()], {type: 'text/csv'}), fileName('csv', this.#what()));
  }

  saveImage() {
    const {scene, name} = this.page();
    saveCanvas(this.plots.image(this.plots.comparing ? scene : `${scene}, ${name}`), fileName('png', this.#what()));
  }

  #what() {
    const {scene, name} = this.page();
    return this.plots.comparing ? scene : `${scene}-${name}`;
  }
}
