// The robots on the scene's seats, in the 3D view and in lines of text: the tool, the target that its controller holds, the force on the tool.

import {EdgesGeometry, Group, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, MeshLambertMaterial, OctahedronGeometry, Vector3} from 'three';
import {Arrows, rodShape} from './arrows.js';
import {say} from './language.js';
import {length3, ROBOT_AT} from './messages.js';
import {Pool} from './pool.js';

const STATES = ['disabled', 'ready', 'engaged', 'clutched', 'hold', 'fault', 'aligning'];
const FLAG = {sensed: 1, well: 2, stopped: 4, touches: 8};
const seatOf = (flags) => flags >> 8 & 0xff;
const SIZE = 9;  // [pixels] of the tool, from its middle

const shape = new OctahedronGeometry(1);
const [tool, target, vector] = Array.from({length: 3}, () => new Vector3());

export class Robots {
  constructor() {
    this.group = new Group();
    this.all = [];
    this.colors = null;
    this.strongest = 0;  // [N] of the forces on their tools
  }

  /** @param {object} colors of the theme */
  paint(colors) {
    this.colors = colors;
    for (const robot of this.all) robot.paint(colors);
  }

  /** @param {import('./messages.js').Picture} picture @param {{perNewton: number, pixel: number}} how */
  show(picture, how) {
    const places = picture.robotsAt();
    while (this.all.length < places.length) {
      const robot = new Robot();
      if (this.colors) robot.paint(this.colors);
      this.group.add(robot.group);
      this.all.push(robot);
    }
    this.strongest = 0;
    this.all.forEach((robot, i) => {
      robot.show(picture, places[i] ?? -1, how);
      this.strongest = Math.max(this.strongest, robot.newtons);
    });
  }

  /** For tests. @returns {{tool: number[], target: number[], forces: number}[]} what is drawn */
  look() {
    return this.all.map((robot) => robot.look()).filter((robot) => robot !== null);
  }
}

class Robot {
  constructor() {
    this.group = new Group();
    this.tool = new Mesh(shape, new MeshLambertMaterial());
    this.target = new LineSegments(new EdgesGeometry(shape), new LineBasicMaterial({transparent: true, depthTest: false, depthWrite: false}));
    this.target.renderOrder = 4;
    this.spring = new Pool(rodShape, new MeshBasicMaterial({transparent: true, depthTest: false, depthWrite: false}), this.group, 4);
    this.force = new Arrows(this.group, {width: 4.5, opacity: 1, order: 6});
    this.group.add(this.tool, this.target);
    this.group.visible = false;
  }

  /** @param {object} colors of the theme */
  paint(colors) {
    this.tool.material.color.set(colors.guide);
    this.target.material.color.set(colors.guide);
    this.spring.material.color.set(colors.muted);
    this.force.material.color.set(colors.elastic);
  }

  /** @param {import('./messages.js').Picture} picture @param {number} at where its record begins; negative: it is gone */
  show(picture, at, how) {
    this.group.visible = at >= 0;
    this.newtons = 0;
    if (at < 0) return;
    const {floats} = picture;
    tool.fromArray(floats, at + ROBOT_AT.position);
    target.fromArray(floats, at + ROBOT_AT.target);
    place(this.tool, tool, floats, at + ROBOT_AT.orientation, SIZE * how.pixel);
    place(this.target, target, floats, at + ROBOT_AT.targetTurn, 1.3 * SIZE * how.pixel);
    this.spring.clear();
    this.spring.addAlong(tool, vector.copy(target).sub(tool), how.pixel);
    this.spring.done();
    this.force.clear();
    if (picture.words[at + ROBOT_AT.flags] & FLAG.sensed) {
      this.newtons = vector.fromArray(floats, at + ROBOT_AT.force).length();
      this.force.add(tool, vector.multiplyScalar(how.perNewton), how.pixel);
    }
    this.force.done();
  }

  look() {
    if (!this.group.visible) return null;
    return {tool: this.tool.position.toArray(), target: this.target.position.toArray(), forces: this.force.heads.count};
  }
}

/** In the record, quaternions are w, x, y, z. */
function place(object, position, floats, turn, size) {
  object.position.copy(position);
  object.quaternion.set(floats[turn + 1], floats[turn + 2], floats[turn + 3], floats[turn]);
  object.scale.setScalar(size);
}

/**
 * @param {import('./messages.js').Picture | null} picture
 * @param {string[]} seats names of the scene's seats; an only seat has none
 * @returns {{state: string, values: string}[]} a line for each robot
 */
export function robotTexts(picture, seats) {
  return (picture?.robotsAt() ?? []).map((at) => robotText(picture, at, seats));
}

function robotText({floats, words}, at, seats) {
  const flags = words[at + ROBOT_AT.flags];
  const hand = words[at + ROBOT_AT.hand];
  const values = [hand > 0 ? say('robot.led', {hand}) : say('robot.unled')];
  values.push(flags & FLAG.sensed ? say('robot.force', {force: length3(floats, at + ROBOT_AT.force).toFixed(2)}) : say('robot.numb'));
  if (flags & FLAG.touches) values.push(say('robot.touches'));
  if (flags & FLAG.stopped) values.push(say('robot.stopped'));
  else if (!(flags & FLAG.well)) values.push(say('robot.unwell'));
  const name = [say('robot.name'), seats[seatOf(flags)]].filter(Boolean).join(' ');
  return {state: say('robot.state', {name, state: say(`robot.${STATES[words[at + ROBOT_AT.state]] ?? 'unknown'}`)}), values: values.join(', ')};
}
