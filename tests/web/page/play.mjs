// The mock server's scene: a floor, a ramp, moving balls, and hands that press them.

import {bits} from './members.mjs';

const STIFFNESS = 1000;  // [N/m]
const STRONGEST = 2.2;  // [N] of the device
const RADIUS = 0.03;  // [m] of the first ball

/** @returns {{positions: number[], corners: number[]}} */
export function boxShape([x, y, z], [cx, cy, cz] = [0, 0, 0]) {
  const positions = [];
  for (let i = 0; i < 8; ++i) positions.push(cx + (i & 1 ? x : -x), cy + (i & 2 ? y : -y), cz + (i & 4 ? z : -z));
  const corners = [0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5];
  return {positions, corners};
}

/** @returns {{positions: number[], corners: number[]}} */
export function ballShape(radius, rings = 16) {
  const positions = [];
  const corners = [];
  const around = 2 * rings;
  for (let i = 0; i <= rings; ++i) {
    for (let j = 0; j < around; ++j) {
      const [polar, turn] = [(Math.PI * i) / rings, (2 * Math.PI * j) / around];
      positions.push(radius * Math.sin(polar) * Math.cos(turn), radius * Math.sin(polar) * Math.sin(turn), radius * Math.cos(polar));
      if (i === rings) continue;
      const [a, b] = [i * around + j, i * around + ((j + 1) % around)];
      if (i > 0) corners.push(a, a + around, b);
      if (i < rings - 1) corners.push(b, a + around, b + around);
    }
  }
  return {positions, corners};
}

/** What a server makes of a mesh: a cup of thin walls, open above. @returns {{positions: number[], corners: number[]}} */
export function cupShape(radius, height, around = 24) {
  const positions = [0, 0, 0];
  const corners = [];
  for (let j = 0; j < around; ++j) {
    const turn = (2 * Math.PI * j) / around;
    for (const z of [0, height]) positions.push(radius * Math.cos(turn), radius * Math.sin(turn), z);
    const [a, b] = [1 + 2 * j, 1 + 2 * ((j + 1) % around)];
    corners.push(0, b, a, a, b, a + 1, b, b + 1, a + 1);
  }
  return {positions, corners};
}

/** What a server makes of a distance field: the surface of a block of cells, each cell's face of two triangles. @returns {{positions: number[], corners: number[]}} */
export function gridShape(half, cells = 16) {
  const positions = [];
  const corners = [];
  for (let axis = 0; axis < 3; ++axis) {
    for (const side of [-half, half]) {
      const first = positions.length / 3;
      for (let i = 0; i <= cells; ++i) {
        for (let j = 0; j <= cells; ++j) {
          const place = [0, 0, 0];
          place[axis] = side;
          place[(axis + 1) % 3] = half * (2 * i / cells - 1);
          place[(axis + 2) % 3] = half * (2 * j / cells - 1);
          positions.push(...place);
          if (i === cells || j === cells) continue;
          const [a, b] = [first + i * (cells + 1) + j, first + (i + 1) * (cells + 1) + j];
          corners.push(...(side > 0 ? [a, b, b + 1, a, b + 1, a + 1] : [a, b + 1, b, a, a + 1, b + 1]));
        }
      }
    }
  }
  return {positions, corners};
}

/** @returns {Buffer} a message of kind 1 */
export function geometryMessage(index, version, {positions, corners}) {
  const buffer = Buffer.alloc(20 + 4 * positions.length + 4 * corners.length);
  [1, index, version, positions.length / 3, corners.length / 3].forEach((word, i) => buffer.writeUInt32LE(word, 4 * i));
  positions.forEach((value, i) => buffer.writeFloatLE(value, 20 + 4 * i));
  corners.forEach((corner, i) => buffer.writeUInt32LE(corner, 20 + 4 * positions.length + 4 * i));
  return buffer;
}

export class Play {
  constructor(hands, bodies) {
    this.hands = hands;
    this.bodies = bodies;
    this.version = 1;
    this.silent = false;  // whether there are no pictures
    this.still = false;  // whether no hand touches anything
    this.observes = false;  // whether no change can be made, as at a gateway
    this.seats = [''];  // names of the seats for robots
    this.robots = [];  // {state, hand, flags} of those on the scene's seats
    this.modelled = true;  // whether clients have local models
    this.guided = ['rail', 'honey', 'wind'];  // names of the scene's guides
    this.names = ['alice', 'bob', 'carol', 'dave'];  // of clients; others are guests
    this.reasons = null;  // of every hand; null: what it does
    this.balance = null;  // [J] of every account; null: some
    this.gain = 1;  // of all forces
    this.over = 1;  // of the force that devices hold
    this.away = [0, 0, 0];  // [m] that the first hand is away from the others
    this.began = process.hrtime.bigint();
    this.energy = Array.from({length: hands}, () => ({delivered: 0, burned: 0, force: 0, depth: 0}));
    const ball = ballShape(RADIUS);
    const small = ballShape(0.006, 8);
    this.shapes = [{index: 1, shape: boxShape([0.02, 0.05, 0.012], [-0.07, 0.03, 0.012])}];
    for (let i = 0; i < bodies; ++i) this.shapes.push({index: 2 + i, shape: i === 0 ? ball : small});
  }

  get time() {
    return Number(process.hrtime.bigint() - this.began) / 1e9 + 100;
  }

  scene(name) {
    const objects = [
      {index: 0, name: 'floor', moves: false, stiffness: STIFFNESS, felt_from: 'outside', plane: {point: [0, 0, 0], normal: [0, 0, 1]}},
      {index: 1, name: 'block', moves: false, stiffness: STIFFNESS, felt_from: 'outside'},
    ];
    for (let i = 0; i < this.bodies; ++i) {
      objects.push({index: 2 + i, name: `ball ${i}`, moves: true, stiffness: STIFFNESS, felt_from: 'outside'});
    }
    return {
      type: 'scene', name, version: this.version, objects, seats: this.seats, box: [[-0.1, -0.08, 0], [0.1, 0.08, 0.1]],
      tools: [
        {name: 'tip', radius: 0.004, points: []},
        {name: 'peg', radius: 0, points: Array.from({length: 60}, (_, i) => [0.004 * Math.cos(i), 0.004 * Math.sin(i), 0.0005 * i])},
      ],
      guides: this.#guides().filter(({name}) => this.guided.includes(name)),
    };
  }

  #guides() {
    const {positions, corners} = boxShape([0.03, 0.02, 0.02], [0.05, -0.05, 0.07]);
    const triples = (values) => Array.from({length: values.length / 3}, (_, i) => values.slice(3 * i, 3 * i + 3));
    return [
      {name: 'rail', kind: 'attract', closed: false, points: [[-0.09, -0.06, 0.03], [0.09, -0.06, 0.03]], vertices: [], triangles: []},
      {name: 'honey', kind: 'viscosity', closed: false, points: [], vertices: triples(positions), triangles: triples(corners)},
      {name: 'wind', kind: 'constant_force', closed: false, points: [], vertices: [], triangles: []},
    ];
  }

  sessions() {
    const sessions = Array.from({length: this.hands}, (_, i) => ({
      number: i + 1, tool: i === 1 ? 'peg' : 'tip', client: this.names[i] ?? `guest${i}`, device: i === 1 ? 'simulated' : 'falcon', session: `${4711 + i}`, mode: i === 1 ? 'contact_frame' : 'shaped', side: i === 1 ? 'server' : 'client', rate_hz: 1000,
      packet_hz: 500, round_trip_ms: i === 3 ? null : 3.1 + i, loss: i === 1 ? 0.013 : 0, delivered_j: this.energy[i].delivered,
      samples: Math.floor(1000 * (this.time - 100)), seconds: this.time - 100,
      wakeups: i === 0 ? this.#counts(0) : null, round_trips: i === 0 ? this.#counts(2) : null,
      projection: 'cone', storage: 'minimal', laws_taken: i === 2 ? 'safe' : 'none', link_taken: i === 2,
      lead_share: i === 2 ? 0.5 : null, local_model: i !== 1, samples_per_s: 1000, late_ticks: i, burned_j: this.energy[i].burned,
      hand_damping: i === 0 ? 1.5 : null, reference: 'zero', operator_damping: 0, velocity_cutoff: 0, c1: null, c2: null,
      coupling_stiffness: null, coupling_damping: null, tool_mass: 0.05,
      asked: i === 2 ? 'mode shaped -> none' : null, answer: i === 2 ? 'refused' : null,
    }));
    return {type: 'sessions', time: this.time, sessions};
  }

  /** Counts by class: one a millisecond in class `first`, and three in the last class. @param {number} first */
  #counts(first) {
    const samples = Math.floor(1000 * (this.time - 100));
    return Array.from({length: 8}, (_, i) => (i === first ? samples : i === 7 ? 3 * samples : 7));
  }

  /** @returns {Buffer} a message of kind 2 */
  picture() {
    const {time} = this;
    const buffer = Buffer.alloc(24 + 112 * this.hands + 32 * this.bodies + 100 * this.robots.length);
    [2, this.hands, this.bodies, this.version].forEach((word, i) => buffer.writeUInt32LE(word, 4 * i));
    buffer.writeDoubleLE(time, 16);
    for (let i = 0; i < this.hands; ++i) this.#hand(i, time, buffer, 24 + 112 * i);
    for (let i = 0; i < this.bodies; ++i) {
      const at = 24 + 112 * this.hands + 32 * i;
      buffer.writeUInt32LE(2 + i, at);
      const angle = 0.3 * time + i;
      [...this.place(i, time), Math.cos(angle / 2), 0, 0, Math.sin(angle / 2)].forEach((value, j) => buffer.writeFloatLE(value, at + 4 + 4 * j));
    }
    this.robots.forEach((robot, i) => this.#robot(robot, buffer, 24 + 112 * this.hands + 32 * this.bodies + 100 * i));
    return buffer;
  }

  /** Of the i-th body. @returns {number[]} [m] */
  place(i, time) {
    if (i === 0) return this.#ball(time);
    return [0.09 * Math.cos(i * 2.4), 0.07 * Math.sin(i * 1.7), 0.006 + 0.09 * ((i * 0.618) % 1) + 0.004 * Math.sin(0.3 * time + i)];
  }

  #robot(robot, buffer, at) {
    [robot.state, robot.hand, robot.flags].forEach((word, i) => buffer.writeUInt32LE(word, at + 4 * i));
    const still = [1, 0, 0, 0];
    [0.02, 0.03, 0.04, ...still, 0.02, 0.03, 0.02, ...still, 0, -3, 4, 0, 0, 0, 0, 0.01].forEach((value, i) => buffer.writeFloatLE(value, at + 12 + 4 * i));
  }

  /** @returns {Buffer} a message of kind 3: a flat piece under each hand that is on the floor */
  surfaces() {
    const [picture, patches] = [this.picture(), []];
    for (let i = 0; i < this.hands; i += 2) {
      const proxy = 24 + 112 * i + 36;
      patches.push([i + 1, picture.readFloatLE(proxy), picture.readFloatLE(proxy + 4)]);
    }
    const buffer = Buffer.alloc(12 + 60 * patches.length);
    [3, this.version, patches.length].forEach((word, i) => buffer.writeUInt32LE(word, 4 * i));
    patches.forEach(([hand, x, y], k) => {
      buffer.writeUInt32LE(hand, 12 + 60 * k);
      buffer.writeUInt32LE(1, 16 + 60 * k);
      [x, y, 0, 0, 0, 1, 0, 0, 0, 0, 0.02, 0.05, 0].forEach((value, j) => buffer.writeFloatLE(value, 20 + 60 * k + 4 * j));
    });
    return buffer;
  }

  #ball(time) {
    return [0.05 + 0.005 * Math.sin(0.5 * time), 0.01, RADIUS];
  }

  #hand(i, time, buffer, at) {
    const phase = 1.7 * i;
    const press = this.still ? -1 : Math.sin(0.9 * time + phase);
    const deep = Math.max(0, 0.0026 * press + 0.001);  // [m]
    const above = Math.max(0, -0.02 * press - 0.008);
    const onBall = i % 2 === 1;
    const turn = 0.7 * time + phase;
    const normal = onBall ? [Math.sin(0.5) * Math.cos(turn), Math.sin(0.5) * Math.sin(turn), Math.cos(0.5)] : [0, 0, 1];
    const reach = 0.02 + 0.006 * (i >> 1);
    const way = [-Math.sin(turn), Math.cos(turn), 0];
    const ball = this.#ball(time);
    const surface = onBall ? normal.map((n, k) => ball[k] + RADIUS * n) : [-0.02 + reach * Math.cos(turn), reach * Math.sin(turn) - 0.01 * (i >> 1), 0];
    const proxy = surface.map((x, k) => x + above * normal[k] + (i === 0 ? this.away[k] : 0));
    const position = proxy.map((x, k) => x - deep * normal[k]);
    const elastic = normal.map((n) => STIFFNESS * deep * n);
    const friction = way.map((w) => -0.35 * STIFFNESS * deep * w);
    const sum = elastic.map((e, k) => e + friction[k]);
    const size = Math.hypot(...sum);
    const fit = size > STRONGEST ? STRONGEST / size : 1;
    const cut = deep > 0 && Math.sin(3 * time + i) > 0.6 ? 0.8 : 1;
    const rendered = sum.map((f) => fit * cut * f);
    const own = this.energy[i];
    own.delivered += -STIFFNESS * deep * (deep - own.depth) - 0.0002 * size;
    own.burned += 0.00012 * size;
    own.depth = deep;
    const reasons = this.reasons ?? ((cut < 1 ? bits('account') : 0) | (fit < 1 ? bits('saturated') : 0) | bits(deep > 0 ? 'touching' : 'free_space'));
    buffer.writeUInt32LE(i + 1, at);
    buffer.writeUInt32LE(reasons >>> 0, at + 4);
    const tilt = 0.35;
    [...position, Math.cos(tilt / 2), Math.sin(tilt / 2) * Math.sin(turn / 3), Math.sin(tilt / 2) * Math.cos(turn / 3), 0, ...proxy,
      ...[...elastic, ...friction, ...rendered.map((f) => this.over * f)].map((f) => this.gain * f), deep, own.delivered, own.burned, this.balance ?? 0.004 + 0.002 * Math.sin(time), 1000, i === 1 ? 0.013 : 0,
      i === 3 ? NaN : 0.0031 + 0.001 * i + 0.0004 * Math.sin(7 * time)].forEach((value, k) => buffer.writeFloatLE(value, at + 8 + 4 * k));
  }
}
