// The surroundings of the hands of a recording, which does not know the scene: a box with a grid on its floor, and the way of a hand.

import {BufferGeometry, Float32BufferAttribute, Group, LineBasicMaterial, LineSegments} from 'three';

export class Box {
  constructor() {
    this.group = new Group();
    this.edges = new LineSegments(new BufferGeometry(), new LineBasicMaterial({depthWrite: false}));
    this.way = new LineSegments(new BufferGeometry(), new LineBasicMaterial({transparent: true, opacity: 0.6}));
    this.edges.renderOrder = -1;  // The axes stand before it.
    this.group.add(this.edges, this.way);
  }

  /** @param {object} colors of the theme */
  paint(colors) {
    this.edges.material.color.set(colors.grid);
    this.way.material.color.set(colors.line);
  }

  /** @param {number[]} low @param {number[]} high corners [m] @param {number} spacing [m] of the grid */
  fit(low, high, spacing) {
    const points = [];
    for (let axis = 0; axis < 2; ++axis) {
      const [begin, end] = [[...low], [low[0], low[1], low[2]]];
      end[1 - axis] = high[1 - axis];
      for (let at = low[axis]; at <= high[axis] + 1e-9; at += spacing) {
        begin[axis] = end[axis] = at;
        points.push(...begin, ...end);
      }
    }
    for (let i = 0; i < 8; ++i) {
      for (let axis = 0; axis < 3; ++axis) {
        if (i & (1 << axis)) continue;
        const corner = (bits) => [0, 1, 2].map((k) => (bits & (1 << k) ? high[k] : low[k]));
        points.push(...corner(i), ...corner(i | (1 << axis)));
      }
    }
    put(this.edges, points);
  }

  /** @param {Float32Array} places x, y, z of each part of the time; NaN: none */
  follow(places) {
    const points = [];
    for (let i = 3; i < places.length; i += 3) {
      if (!Number.isNaN(places[i - 3]) && !Number.isNaN(places[i])) points.push(...places.subarray(i - 3, i + 3));
    }
    put(this.way, points);
  }
}

function put(lines, points) {
  lines.geometry.dispose();
  lines.geometry = new BufferGeometry();
  lines.geometry.setAttribute('position', new Float32BufferAttribute(points, 3));
}
