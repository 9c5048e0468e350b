// The scene in a recording of the live page or of a server: its description, the triangles of its objects, and where they were.

import {say} from '../language.js';
import {Quaternion, Vector3} from 'three';
import {bodiesAt} from './bodies.js';
import {Fields} from './protobuf.js';
import {FRESH, readPose} from './tables.js';

const BODY = /^body (\d{1,9})$/;
const [position, turn] = [new Vector3(), new Quaternion()];

/**
 * @param {Object<string, string>} values of the metadata record "scene"
 * @returns {object | null} the server's message `scene` as it was when the recording began; null: there is none that can be used
 */
export function sceneOf(values) {
  try {
    const scene = JSON.parse(values.message);
    const isPoint = (point) => Array.isArray(point) && point.length === 3 && point.every(Number.isFinite);
    const good = Array.isArray(scene.objects) && scene.box?.length === 2 && scene.box.every(isPoint) && scene.objects.every(({index, name, plane}) => (
      Number.isInteger(index) && typeof name === 'string' && (!plane || (isPoint(plane.point) && isPoint(plane.normal)))));
    return good ? {...scene, guides: [], tools: []} : null;
  } catch {
    return null;
  }
}

/**
 * Throws a RangeError where the message does not fit.
 * @param {DataView} bytes of a foxglove.SceneUpdate @param {object} scene as sceneOf() gives it
 * @returns {{index: number, version: number, positions: Float32Array, corners: Uint32Array}[]} what the 3D view takes
 */
export function trianglesOf(bytes, scene) {
  const still = new Map(scene.objects.filter(({moves, plane}) => !moves && !plane).map(({index, name}) => [name, index]));
  const found = [];
  for (const update = new Fields(bytes, 0, bytes.byteLength); update.next();) {
    if (update.number !== 2) continue;
    const [object, entity] = [{frame: '', id: '', list: null}, update.message()];
    while (entity.next()) {
      if (entity.number === 2) object.frame = entity.text();
      if (entity.number === 3) object.id = entity.text();
      if (entity.number === 12) object.list = entity.message();
    }
    const index = BODY.test(object.frame) ? Number(BODY.exec(object.frame)[1]) : still.get(object.id);
    if (object.list && index !== undefined) found.push({index, version: scene.version, ...readTriangles(object.list)});
  }
  return found;
}

function readTriangles(list) {
  const pose = Float32Array.of(0, 0, 0, 1, 0, 0, 0);
  const positions = [];
  let corners = new Uint32Array(0);
  const point = new Float64Array(3);
  while (list.next()) {
    if (list.number === 1) readPose(list.message(), pose, 0, 3);
    if (list.number === 2) {
      list.numbers(point, 0, 3);
      positions.push(...point);
    }
    if (list.number === 5) corners = Uint32Array.from({length: (list.end - list.begin) >> 2}, (_, i) => list.view.getUint32(list.begin + 4 * i, true));
  }
  for (const corner of corners) if (3 * corner >= positions.length) throw new RangeError(say('file.range.corner'));
  turn.set(pose[4], pose[5], pose[6], pose[3]);
  for (let i = 0; i < positions.length; i += 3) {
    position.fromArray(positions, i).applyQuaternion(turn);
    for (let axis = 0; axis < 3; ++axis) positions[i + axis] = position.getComponent(axis) + pose[axis];
  }
  return {positions: Float32Array.from(positions), corners};
}

/**
 * @param {import('./tables.js').Segment[]} segments @param {number} time [s]
 * @returns {Map<number, Float32Array>} by the index of the object: position, then w, x, y, z
 */
export function placesAt(segments, time) {
  const places = new Map();
  for (const [name, {pose}] of bodiesAt(segments, time)) if (BODY.test(name)) places.set(Number(BODY.exec(name)[1]), pose);  // A server's file has no transforms.
  for (const {transforms} of segments) {
    for (const {time: at, bytes} of transforms) {
      if (at > time || at < time - FRESH) continue;
      for (const all = new Fields(bytes, 0, bytes.byteLength); all.next();) readTransform(all.message(), places);
    }
  }
  return places;
}

function readTransform(transform, places) {
  const pose = Float32Array.of(0, 0, 0, 1, 0, 0, 0);
  const turned = new Float64Array(4);
  let index = null;
  while (transform.next()) {
    if (transform.number === 3) index = BODY.exec(transform.text())?.[1] ?? null;
    if (transform.number === 4) transform.numbers(pose, 0, 3);
    if (transform.number === 5) {
      transform.numbers(turned, 0, 4);
      pose.set([turned[3], turned[0], turned[1], turned[2]], 3);
    }
  }
  if (index !== null) places.set(Number(index), pose);
}
