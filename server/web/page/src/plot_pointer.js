// Zooming and moving the time of a plot: wheel, drag, and two fingers.

const NOTCH = 1 / 400;  // zoom by a unit of the wheel, of which a notch has some 100
const LINE = 33;  // units of the wheel, where it counts lines
const BEGUN = 4;  // [px] from which a press is a drag

/**
 * @param {HTMLElement} room of the plot
 * @param {{zoom: (factor: number, share: number) => void, move: (share: number) => void, area: () => HTMLElement}} on
 *   shares are of the area that is plotted: for zoom the place that stays, for move the way to later times
 */
export function moveByPointer(room, on) {
  const pointers = new Map();
  let dragged = false;
  const area = () => on.area().getBoundingClientRect();
  const shareOf = (x) => {
    const {left, width} = area();
    return Math.min(Math.max((x - left) / Math.max(width, 1), 0), 1);
  };
  room.addEventListener('wheel', (event) => {
    if (event.ctrlKey || event.deltaY === 0) return;
    event.preventDefault();
    on.zoom(Math.exp(-event.deltaY * NOTCH * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE : 1)), shareOf(event.clientX));
  }, {passive: false});
  room.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    if (pointers.size === 0) dragged = false;
    pointers.set(event.pointerId, event.clientX);
  });
  room.addEventListener('pointermove', (event) => {
    const last = pointers.get(event.pointerId);
    if (last === undefined || (!dragged && pointers.size === 1 && Math.abs(event.clientX - last) < BEGUN)) return;
    if (!dragged) room.setPointerCapture(event.pointerId);
    dragged = true;
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
    pointers.set(event.pointerId, event.clientX);
    if (other === undefined) return on.move((last - event.clientX) / Math.max(area().width, 1));
    const [before, after] = [Math.abs(last - other), Math.abs(event.clientX - other)];
    if (before > BEGUN && after > BEGUN) on.zoom(after / before, shareOf((event.clientX + other) / 2));
  });
  for (const end of ['pointerup', 'pointercancel']) room.addEventListener(end, (event) => pointers.delete(event.pointerId));
}
