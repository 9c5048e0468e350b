// The WebGL context of a 3D view.

/**
 * Makes the context once; later calls with the same canvas get the same one.
 * @param {HTMLCanvasElement} canvas @returns {WebGL2RenderingContext | null} null: the browser gives none
 */
export const makeContext = (canvas) =>
  canvas.getContext('webgl2', {alpha: true, depth: true, stencil: false, antialias: true, powerPreference: 'high-performance'});
