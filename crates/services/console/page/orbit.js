// Turning and zooming a view by pointers, wheel and keys.

const turnOfPixel = 0.008;
const lowest = -0.2;
const highest = 1.55;

/** The angles of a view that is first seen from a corner, slightly from above. */
export const firstView = () => ({ azimuth: -2.14, elevation: 0.71, zoom: 1 });

/**
 * Lets a canvas be turned: `view` is changed, and `onChange` called. `onPick` hears of a tap or click, with its place in the canvas
 * as shares of its width and height.
 */
export const orbit = (canvas, view, onChange, onPick) => {
  const turn = (azimuth, elevation) => {
    view.azimuth += azimuth;
    view.elevation = Math.max(lowest, Math.min(highest, view.elevation + elevation));
    onChange();
  };
  const zoom = (factor) => {
    view.zoom = Math.max(0.5, Math.min(6, view.zoom * factor));
    onChange();
  };
  const reset = () => {
    Object.assign(view, firstView());
    onChange();
  };

  const pointers = new Map();
  let moved = 0;
  const spread = () => {
    const [one, other] = [...pointers.values()];
    return Math.hypot(one[0] - other[0], one[1] - other[1]) || 1;
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    if (pointers.size === 0) moved = 0;
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const apart = pointers.size === 2 ? spread() : null;
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    const [right, down] = [event.clientX - before[0], event.clientY - before[1]];
    moved += Math.abs(right) + Math.abs(down);
    if (apart !== null) zoom(spread() / apart);
    else if (pointers.size === 1) turn(-right * turnOfPixel, down * turnOfPixel);
  });
  canvas.addEventListener('pointerup', (event) => {
    const isTap = pointers.size === 1 && moved < 6;
    pointers.delete(event.pointerId);
    if (!isTap) return;
    const box = canvas.getBoundingClientRect();
    onPick((event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height);
  });
  canvas.addEventListener('pointercancel', (event) => pointers.delete(event.pointerId));
  canvas.addEventListener('wheel', (event) => {
    if (document.activeElement !== canvas) return; // The page scrolls until the view is chosen.
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * 0.001));
  }, { passive: false });

  const keys = {
    ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1),
    '+': () => zoom(1.15), '=': () => zoom(1.15), '-': () => zoom(1 / 1.15), 0: reset,
  };
  canvas.addEventListener('keydown', (event) => {
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
  });
  return { turn, zoom, reset };
};
