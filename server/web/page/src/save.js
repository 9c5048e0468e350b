// Files that the browser saves.

/** @param {string} ending of the name @param {string} what is in it @returns {string} a name with the time */
export const fileName = (ending, what) => (
  `feltwire-${what}-${new Date().toISOString().slice(0, 19).replaceAll(':', '-')}.${ending}`.replace(/[^\w.-]+/g, '_'));

/** @param {Blob} blob @param {string} name */
export function save(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

/** @param {HTMLCanvasElement} canvas @param {string} name */
export const saveCanvas = (canvas, name) => canvas.toBlob((blob) => save(blob, name), 'image/png');
