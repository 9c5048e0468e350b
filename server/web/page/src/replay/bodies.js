// The bodies of a recorded scene: the cubes of foxglove.SceneUpdate, where each was said to be last.

import {Fields} from './protobuf.js';
import {FRESH, readPose} from './tables.js';

const CORNERS = [0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5];

/**
 * @param {import('./tables.js').Segment[]} segments @param {number} time [s]
 * @returns {Map<string, {pose: Float32Array, size: Float32Array}>} by name; pose: position, then w, x, y, z; size [m] along the body's axes
 */
export function bodiesAt(segments, time) {
  const bodies = new Map();
  for (const segment of segments) {
    for (const picture of segment.pictures) {
      if (picture.time > time || picture.time < time - FRESH) continue;
      apply(bodies, new Fields(picture.bytes, 0, picture.bytes.byteLength));
    }
  }
  return bodies;
}

function apply(bodies, update) {
  while (update.next()) {
    const part = update.message();
    if (update.number === 1) {
      while (part.next()) if (part.number === 3) bodies.delete(part.text());
    } else if (update.number === 2) {
      let id = '';
      const body = {pose: new Float32Array(7), size: new Float32Array(3)};
      let isBody = false;
      while (part.next()) {
        if (part.number === 3) id = part.text();
        if (part.number === 8) {
          isBody = true;
          readCube(part.message(), body);
        }
      }
      if (isBody) bodies.set(id, body);
    }
  }
}

function readCube(cube, body) {
  while (cube.next()) {
    if (cube.number === 1) readPose(cube.message(), body.pose, 0, 3);
    if (cube.number === 2) cube.numbers(body.size, 0, 3);
  }
}

/** A cube as the 3D view takes it. @param {number} index @param {Float32Array} size [m] */
export function cubeGeometry(index, size) {
  const positions = new Float32Array(24);
  for (let i = 0; i < 8; ++i) for (let axis = 0; axis < 3; ++axis) positions[3 * i + axis] = (i & (1 << axis) ? 0.5 : -0.5) * size[axis];
  return {index, version: 1, positions, corners: Uint32Array.from(CORNERS)};
}
