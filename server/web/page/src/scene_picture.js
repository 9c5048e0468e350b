// The 3D view as an image: what is drawn, the names over it, and a line that says its scales.

const LINE = 26;  // [px] height of the line below
const FONT = '12px system-ui, sans-serif';

/**
 * @param {import('./view.js').View} view @param {HTMLElement} labels its names @param {string} text of the line below
 * @param {{name: string, color: string}[]} kinds of arrows @returns {HTMLCanvasElement}
 */
export function scenePicture(view, labels, text, kinds) {
  const {canvas, colors} = view;
  view.draw();
  const made = document.createElement('canvas');
  const ratio = canvas.width / view.width;
  const [width, height] = [canvas.width, canvas.height + Math.round(LINE * ratio)];
  Object.assign(made, {width, height});
  const context = made.getContext('2d');
  context.fillStyle = colors.view;
  context.fillRect(0, 0, width, height);
  context.drawImage(canvas, 0, 0);  // In the task that drew it: later the browser has cleared it.
  context.scale(ratio, ratio);
  context.textBaseline = 'middle';
  const corner = labels.getBoundingClientRect();
  for (const label of labels.children) {
    if (label.hidden || label.style.visibility === 'hidden') continue;
    const style = getComputedStyle(label);
    const box = label.getBoundingClientRect();
    const [x, y] = [box.left - corner.left, box.top - corner.top];
    if (!label.classList.contains('axis')) context.fillRect(x, y, box.width, box.height);
    write(context, label.textContent, x + parseFloat(style.paddingLeft), y + box.height / 2, style.color, `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`);
  }
  let x = 10;
  const y = view.height + LINE / 2;
  for (const {name, color} of kinds) {
    context.fillStyle = color;
    context.fillRect(x, y - 2, 18, 4);
    x += write(context, name, x + 24, y, colors.ink) + 38;
  }
  write(context, text, x + 8, y, colors.muted);
  return made;
}

/** @returns {number} width of the text [px] */
function write(context, text, x, y, color, font = FONT) {
  context.font = font;
  const behind = context.fillStyle;
  context.fillStyle = color;
  context.fillText(text, x, y);
  context.fillStyle = behind;
  return context.measureText(text).width;
}
