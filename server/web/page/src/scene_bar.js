// The bar below the scene: what arrows mean, scales, the camera, what is drawn, a picture and a link of what is seen.

import {ArrowScale} from './arrow_scale.js';
import {writeLink} from './link.js';
import {fileName, saveCanvas} from './save.js';
import {scenePicture} from './scene_picture.js';
import * as words from './words.js';

const SAID = 4000;  // [ms] for which it is said what became of a link
const KINDS = [['elastic', 'elastic force'], ['friction', 'friction force'], ['rendered', 'rendered force']];
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
      {keys: ['f'], text: 'show the whole scene and all hands', act: () => this.seeAll()},
      {keys: ['c'], text: 'follow the chosen hand with the camera, or not', act: () => this.follow(!view.follows)},
      {keys: ['x', 'y', 'z'], shown: 'x, y, z', text: 'look along an axis', act: (key) => this.#look(() => view.lookAlong(key))},
      {keys: [',', '.'], shown: ', .', text: 'shorter, longer arrows', act: (key) => this.scaleArrows(key === '.' ? 1 : -1)},
      {keys: ['a'], text: 'arrows scale by themselves, or not', act: () => this.scaleByItself(!this.auto)},
      {keys: [';', "'"], shown: "; '", text: 'less, more exaggeration of depth', act: (key) => this.scaleDepth(key === "'" ? 1 : -1)},
      {keys: ['t'], text: 'trails on or off', act: () => this.showTrails()},
      {keys: ['s'], text: 'surfaces of local models on or off', act: () => this.showSurfaces()},
      {keys: ['i'], text: 'save an image of the scene', act: () => this.savePicture()},
      {keys: ['u'], text: 'copy a link to this view', act: () => this.makeLink()},
    ];
  }

  /** Writes all scales. */
  show() {
    const {view} = this;
    element('arrow-scale').textContent = `1 N = ${words.distance(view.perNewton)}`;
    element('depth-scale').textContent = view.depthFactor === 1 ? 'drawn as it is' : `drawn × ${view.depthFactor}`;
    element('grid-name').textContent = view.objects?.planes.length > 0 ? 'Grid' : 'Axes';
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
    const text = ['arrow-scale', 'grid-scale'].map((id) => element(id).textContent);
    const line = `${scene} · ${text[0]} · depth ${element('depth-scale').textContent} · ${element('grid-name').textContent.toLowerCase()} ${text[1]}`;
    const kinds = KINDS.map(([kind, name]) => ({name, color: view.colors[kind]}));
    saveCanvas(scenePicture(view, element('labels'), line, kinds), fileName('png', scene));
  }

  /** Puts a link to what is seen into the address line and the clipboard. */
  async makeLink() {
    const {scene, chosen} = this.page();
    history.replaceState(null, '', location.pathname + location.search + writeLink({scene, hand: chosen, pose: this.view.pose}));
    let said = 'The link to this view is in the address line.';
    try {
      await navigator.clipboard.writeText(location.href);
      said = 'The link to this view is copied.';
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
