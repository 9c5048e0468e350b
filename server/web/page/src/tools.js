// The tools of hands: a ball about the point of the pen, or a body in its place, as large as the scene says.

import {Group, MeshBasicMaterial, MeshLambertMaterial, OctahedronGeometry, Quaternion, SphereGeometry, Vector3} from 'three';
import {toolPlace} from './hand_view.js';
import {AT} from './messages.js';
import {Pool} from './pool.js';

const DOT = 1.6;  // [pixels] of a body's point
const [center, point, scale] = Array.from({length: 3}, () => new Vector3());
const turn = new Quaternion();
const still = new Quaternion();

export class Tools {
  constructor() {
    this.group = new Group();
    this.balls = new Pool(new SphereGeometry(1, 32, 20), new MeshLambertMaterial({transparent: true, opacity: 0.45, depthWrite: false}), this.group, 1);
    this.dots = new Pool(new OctahedronGeometry(1), new MeshBasicMaterial(), this.group, 1);
    this.tools = [];
    this.held = new Map();  // number of a hand -> name of its tool
    this.colors = {};
  }

  /** @param {{name: string, radius: number, points: number[][]}[]} tools of the server's `scene`; the first is that of a hand without a choice */
  setTools(tools) {
    this.tools = tools;
  }

  /** @param {{number: number, tool: string}[]} sessions of the server's message */
  setSessions(sessions) {
    this.held = new Map(sessions.map(({number, tool}) => [number, tool]));
  }

  /** @param {object} colors of the theme */
  paint(colors) {
    this.colors = colors;
  }

  /** @param {number} number of a hand */
  of(number) {
    const name = this.held.get(number);
    return this.tools.find((tool) => tool.name === name) ?? this.tools[0];
  }

  /** @param {number} number of a hand @returns {boolean} whether a body is drawn instead of a pen */
  hasBody(number) {
    return (this.of(number)?.points ?? []).length > 0;
  }

  /** @param {import('./messages.js').Picture} picture @param {{chosen: number | null, depthFactor: number, pixel: number}} how */
  show(picture, how) {
    this.balls.clear();
    this.dots.clear();
    for (let i = 0; i < picture.hands; ++i) {
      const at = picture.handAt(i);
      const number = picture.words[at + AT.number];
      const tool = this.of(number);
      if (!tool) continue;
      const tint = number === how.chosen ? this.colors.chosen : this.colors.muted;
      toolPlace(picture, i, how.depthFactor, center);
      if (tool.radius > 0) this.balls.add(center, still, scale.setScalar(tool.radius), tint);
      const q = at + AT.orientation;
      turn.set(picture.floats[q + 1], picture.floats[q + 2], picture.floats[q + 3], picture.floats[q]);
      for (const place of tool.points ?? []) {
        point.fromArray(place).applyQuaternion(turn).add(center);
        this.dots.add(point, still, scale.setScalar(DOT * how.pixel), tint);
      }
    }
    this.balls.done();
    this.dots.done();
  }
}
