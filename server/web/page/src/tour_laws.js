// The five steps of the guided tour: what each does, and which hand it watches.

/**
 * @typedef {object} Step
 * @property {string} name of its texts
 * @property {string[]} [laws] bounding methods of a page hand, the first at once; empty text: the usual one
 * @property {number} [delay] [s] of the emulated links, each way @property {boolean} [model] whether the hand that is watched has a local model
 */

/** @type {Step[]} */
export const STEPS = [
  {name: 'none', laws: ['none']},
  {name: 'paper', laws: ['total_energy', 'per_axis', 'per_axis_projected']},
  {name: 'ours', laws: ['']},
  {name: 'delay', delay: 0.025, model: false},
  {name: 'model', delay: 0.05, model: true},
];

/** @param {string} law @returns {string} the end of its texts' keys */
export const lawName = (law) => law || 'usual';

const STIFF = 10_000;  // [N/m] from which a wall shakes without a bound

/** @param {{objects: {plane?: object, stiffness?: number}[]} | null} scene the server's message @returns {{point: number[], normal: number[]} | null} the wall of the tour */
export const wallOf = (scene) => scene?.objects.find(({plane, stiffness}) => plane && stiffness >= STIFF)?.plane ?? null;
