// A link that holds what is seen: the scene, the chosen hand, and the place of the camera. It has no token.

/** @typedef {{position: number[], target: number[]}} Pose of a camera: where it is, and what it looks at [m] */

const NUMBER = 6;  // digits

/**
 * @param {string} hash of an address
 * @returns {{scene: string, hand: number | null, pose: Pose | null}} what it says; an empty scene, or null: nothing
 */
export function readLink(hash) {
  const given = new URLSearchParams(hash.slice(1));
  const numbers = (given.get('view') ?? '').split(',').map(Number);
  const whole = numbers.length === 6 && numbers.every(Number.isFinite);
  const pose = whole ? {position: numbers.slice(0, 3), target: numbers.slice(3)} : null;
  const hand = Number(given.get('hand'));
  return {scene: given.get('scene') ?? '', hand: Number.isInteger(hand) && hand > 0 ? hand : null, pose};
}

/** @param {{scene: string, hand: number | null, pose: Pose}} seen @returns {string} the part of an address from # on */
export function writeLink({scene, hand, pose}) {
  const view = [...pose.position, ...pose.target].map((value) => +value.toPrecision(NUMBER)).join();
  return `#scene=${encodeURIComponent(scene)}${hand === null ? '' : `&hand=${hand}`}&view=${view}`;
}
