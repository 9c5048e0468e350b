// The bar below the scene: what arrows mean, scales, the camera, what is drawn, a picture and a link of what is seen.

import {ArrowScale} from './arrow_scale.js';
import {say} from './language.js';
import {writeLink} from './link.js';
import {fileName, saveCanvas} from './save.js';
import {scenePicture} from './scene_picture.js';
import * as words from './words.js';

const SAID = 4000;  // [ms] for which it is said what became of a link
const KINDS = ['elastic', 'friction', 'rendered'];  // of arrows
const element = (id) => document.getElementById(id);
const press = (id, pressed) => element(id).setAttribute('aria-pressed', String(pressed));

export class SceneBar {
  /** @param {import('./view.js').View} view @param {() => {scene: string, chosen: number | null}} page what is watched */
  constructor(view, page) {
    this.view = view;
    this.page = page;
    this.auto = true;  // whether arrows scale by themselves
    this.arrows = new ArrowScale();
    const acts = {
      'arrow-less': () => this.scaleArrows(-1), 'arrow-more': () => this.scaleArrows(1), 'arrow-auto': () => this.scaleByItself(!this.auto),
      'depth-less': () => this.scaleDepth(-1), 'depth-more': () => this.scaleDepth(1), 'see-all': () => this.seeAll(), follow: () => this.follow(!view.follows),
      trails: () => this.showTrails(), surfaces: () => this.showSurfaces(), picture: () => this.savePicture(), link: () => this.makeLink(),
    };
    for (const [id, act] of Object.entries(acts)) element(id).onclick = act;
  }

  /** Keys of the page that act here. */
  bindings() {
    const {view} = this;
    return [
      {keys: ['f'], text: say('keys.all'), act: () => this.seeAll()},
      {keys: ['c'], text: say('keys.follow'), act: () => this.follow(!view.follows)},
      {keys: ['x', 'y', 'z'], shown: 'x, y, z', text: say('keys.axis'), act: (key) => this.#look(() => view.lookAlong(key))},
      {keys: [',', '.'], shown: ', .', text: say('keys.arrows'), act: (key) => this.scaleArrows(key === '.' ? 1 : -1)},
      {keys: ['a'], text: say('keys.auto'), act: () => this.scaleByItself(!this.auto)},
      {keys: [';', "'"], shown: "; '", text: say('keys.depth'), act: (key) => this.scaleDepth(key === "'" ? 1 : -1)},
      {keys: ['t'], text: say('keys.trails'), act: () => this.showTrails()},
      {keys: ['s'], text: say('keys.surfaces'), act: () => this.showSurfaces()},
      {keys: ['i'], text: say('keys.image'), act: () => this.savePicture()},
      {keys: ['u'], text: say('keys.link'), act: () => this.makeLink()},
    ];
  }

  /** Writes all scales. */
  show() {
    const {view} = this;
    element('arrow-scale').textContent = `1 N = ${words.distance(view.perNewton)}`;
    element('depth-scale').textContent = view.depthFactor === 1 ? say('bar.depth.true') : say('bar.depth.factor', {factor: view.depthFactor});
    element('grid-name').textContent = say(view.objects?.planes.length > 0 ? 'bar.grid' : 'bar.axes');
    element('grid-scale').textContent = words.distance(view.spacing);
    view.stale = true;
  }

  /** After a picture was drawn: arrows become shorter or longer, if they scale by themselves. */
  step() {
    const {view} = this;
    if (!this.auto || !view.picture) return;
    const perNewton = this.arrows.step(view.perNewton, view.strongest, view.pixel * view.height, view.picture.time);
    if (perNewton === view.perNewton) return;
    view.perNewton = perNewton;
    this.show();
  }

  /** @param {boolean} auto */
  scaleByItself(auto) {
    this.auto = auto;
    this.arrows.clear();
    press('arrow-auto', auto);
    this.view.stale = true;
  }

  scaleArrows(steps) {
    this.scaleByItself(false);
    this.view.perNewton = words.stepped(this.view.perNewton, steps);
    this.show();
  }

  /** @param {number | null} perNewton [m] of all arrows from now on; null: they scale by themselves */
  fixArrows(perNewton) {
    this.scaleByItself(perNewton === null);
    if (perNewton !== null) this.view.perNewton = perNewton;
    this.show();
  }

  scaleDepth(steps) {
    this.view.depthFactor = Math.min(Math.max(words.stepped(this.view.depthFactor, steps), 1), 50);
    this.show();
  }

  seeAll() {
    this.#look(() => this.view.lookAtAllHands());
  }

  /** @param {boolean} follows whether the camera keeps the chosen hand in its middle */
  follow(follows) {
    this.view.follows = follows;
    press('follow', follows);
    if (follows) this.view.lookAtHand(this.page().chosen);
  }

  showTrails() {
    const {trails} = this.view.hands;
    trails.shown = !trails.shown;
    press('trails', trails.shown);
    this.view.stale = true;
  }

  showSurfaces() {
    const {surfaces} = this.view;
    surfaces.shown = !surfaces.shown;
    press('surfaces', surfaces.shown);
    this.view.stale = true;
  }

  savePicture() {
    const {view} = this;
    const {scene} = this.page();
    const [arrows, depth, grid, step] = ['arrow-scale', 'depth-scale', 'grid-name', 'grid-scale'].map((id) => element(id).textContent);
    const line = say('bar.image.line', {scene, arrows, depth, grid: grid.toLowerCase(), step});
    const kinds = KINDS.map((kind) => ({name: say(`bar.${kind}`), color: view.colors[kind]}));
    saveCanvas(scenePicture(view, element('labels'), line, kinds), fileName('png', scene));
  }

  /** Puts a link to what is seen into the address line and the clipboard. */
  async makeLink() {
    const {scene, chosen} = this.page();
    history.replaceState(null, '', location.pathname + location.search + writeLink({scene, hand: chosen, pose: this.view.pose}));
    let said = say('bar.link.shown');
    try {
      await navigator.clipboard.writeText(location.href);
      said = say('bar.link.copied');
    } catch {
      // The address line has it.
    }
    element('link-said').textContent = said;
    clearTimeout(this.saying);
    this.saying = setTimeout(() => (element('link-said').textContent = ''), SAID);
  }

  /** Another view ends the following of a hand. */
  #look(act) {
    this.follow(false);
    act();
  }
}
