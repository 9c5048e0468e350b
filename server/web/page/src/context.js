// The WebGL context of a 3D view. Software rendering gets no antialiasing: it would draw each pixel four times.

const COMMON = {alpha: true, depth: true, stencil: false, powerPreference: 'high-performance'};

/**
 * Makes the context once; later calls with the same canvas get the same one.
 * @param {HTMLCanvasElement} canvas @returns {WebGL2RenderingContext | null} null: the browser gives none
 */
export const makeContext = (canvas) =>
  canvas.getContext('webgl2', {...COMMON, antialias: true, failIfMajorPerformanceCaveat: true}) ?? canvas.getContext('webgl2', {...COMMON, antialias: false});
