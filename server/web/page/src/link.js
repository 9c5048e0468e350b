// A link that holds what is seen: the scene, the chosen hand, and the place of the camera. It has no token.

/** @typedef {{position: number[], target: number[]}} Pose of a camera: where it is, and what it looks at [m] */

const NUMBER = 6;  // digits
const FARTHEST = 1e6;  // [m]
const NEAREST = 1e-6;  // [m] from a camera to what it looks at

/**
 * @param {string} hash of an address
 * @returns {{scene: string, hand: number | null, pose: Pose | null}} what it says; an empty scene, or null: nothing
 */
export function readLink(hash) {
  const given = new URLSearchParams(hash.slice(1));
  const numbers = (given.get('view') ?? '').split(',').map((text) => (text.trim() === '' ? NaN : Number(text)));
  const pose = {position: numbers.slice(0, 3), target: numbers.slice(3)};
  const hand = Number(given.get('hand'));
  return {scene: given.get('scene') ?? '', hand: Number.isInteger(hand) && hand > 0 ? hand : null, pose: isPose(numbers) ? pose : null};
}

/** A camera with any other pose shows nothing, and no key moves it away. @param {number[]} numbers the position, then the target */
function isPose(numbers) {
  const distance = Math.hypot(...[0, 1, 2].map((axis) => numbers[axis] - numbers[axis + 3]));
  return numbers.length === 6 && numbers.every((value) => Math.abs(value) <= FARTHEST) && distance >= NEAREST;
}

/** @param {{scene: string, hand: number | null, pose: Pose}} seen @returns {string} the part of an address from # on */
export function writeLink({scene, hand, pose}) {
  const view = [...pose.position, ...pose.target].map((value) => +value.toPrecision(NUMBER)).join();
  return `#scene=${encodeURIComponent(scene)}${hand === null ? '' : `&hand=${hand}`}&view=${view}`;
}
