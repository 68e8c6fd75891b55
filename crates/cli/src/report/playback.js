// Plays a packing step by step: a slider, and what each step decided, beside the view of the container. The slider has two positions a
// step: its item as planned, and everything as it lay then.

const section = document.getElementById('playback');
const absence = document.getElementById('no-playback');
const data = JSON.parse(document.getElementById('playback-data').textContent);
const canvas = section.querySelector('canvas');

// Shapes: base64 of 16-bit numbers, the low byte first.
const numbers = (text) => {
  const bytes = atob(text);
  const all = new Uint16Array(bytes.length / 2);
  for (let at = 0; at < all.length; at += 1) {
    all[at] = bytes.charCodeAt(2 * at) | (bytes.charCodeAt(2 * at + 1) << 8);
  }
  return all;
};
const decoded = (mesh) => {
  const steps = numbers(mesh.vertices);
  const positions = Float32Array.from(steps, (step, at) => mesh.lowest_m[at % 3] + step * mesh.step_m);
  return { positions, triangles: numbers(mesh.triangles), ...bounds(positions) };
};
// Poses are whole numbers: ten-thousandths of a metre, and of a unit quaternion, its real part first.
const matrix = (pose) => {
  const [x, y, z, ...turn] = pose.map((whole) => whole / 1e4);
  const length = Math.hypot(...turn) || 1;
  const [w, i, j, k] = turn.map((part) => part / length);
  return fromPose({ position_m: [x, y, z], orientation: [i, j, k, w] });
};
const channels = (hex) => [1, 3, 5].map((from) => parseInt(hex.slice(from, from + 2), 16) / 255);
const faded = (colour) => colour.map((channel) => 0.45 * channel + 0.55 * 0.72);

const meshes = data.models.map(decoded);
const items = data.steps.map((step) => ({ mesh: meshes[step.model], colour: channels(step.colour) }));
const lying = data.lying.map(({ model, pose }) => ({ mesh: meshes[model], matrix: matrix(pose), colour: [0.7, 0.7, 0.7] }));
const last = 2 * data.steps.length;

// What is to be seen at a position of the slider: where each item lies, and what that step placed or moved.
const state = (position) => {
  const done = Math.floor(position / 2);
  const poses = new Map();
  data.steps.slice(0, done).forEach((step) => {
    step.gone.forEach((item) => poses.delete(item));
    step.shifts.forEach(({ item, pose }) => poses.set(item, matrix(pose)));
  });
  if (position % 2 === 0) {
    return { poses, now: new Set(done > 0 ? data.steps[done - 1].shifts.map(({ item }) => item) : []) };
  }
  const { planned } = data.steps[done];
  if (planned) poses.set(done, matrix(planned));
  return { poses, now: new Set([done]) };
};

const view = new SceneView(canvas, () => {});
const slider = section.querySelector('input');
const play = section.querySelector('.play');
const told = section.querySelector('.now');
let shown = last;
let timer = null;

const element = (text, kind) => {
  const made = document.createElement(kind);
  made.textContent = text;
  return made;
};
const decided = ({ planned_cm, yaw_rad, value, decision_s }) => {
  const [x, y, z] = planned_cm.map((cm) => cm.toFixed(1));
  const turn = (yaw_rad * 180 / Math.PI).toFixed(0);
  return `Planned at x ${x} cm, y ${y} cm, ${z} cm above the floor, turned by ${turn}°; value ${value.toFixed(2)}, `
    + `decided in ${(decision_s * 1e3).toFixed(1)} ms.`;
};
const became = ({ unsteadiness }) => `It ${unsteadiness ?? 'stayed where it was placed'}.`;
const texts = (position, poses) => {
  if (position === 0) return ['Before the first step', lying.length > 0 ? `${lying.length} items lie in the container.` : 'The container is empty.'];
  const number = Math.ceil(position / 2);
  const step = data.steps[number - 1];
  const isPlanned = position % 2 === 1;
  const head = `Step ${number} of ${data.steps.length}: ${step.item}${isPlanned ? ', as planned' : ''}`;
  if (isPlanned) return [head, decided(step)];
  if (!items[number - 1].mesh) return [head, became(step), 'Its shape is not known, and not drawn.'];
  return [head, became(step), ...(poses.has(number - 1) ? [] : ['It is not in the container, and not drawn.'])];
};
const show = (position) => {
  shown = Math.max(0, Math.min(last, position));
  const { poses, now } = state(shown);
  const bodies = [...poses].map(([item, pose]) => {
    const { mesh, colour } = items[item];
    return { mesh, matrix: pose, colour: now.has(item) ? colour : faded(colour) };
  });
  view.show({ size_m: data.container_m, bodies: [...lying, ...bodies.filter(({ mesh }) => mesh)], planned: null, runnersUp: [], surface: null });
  slider.value = String(shown);
  const [head, ...paragraphs] = texts(shown, poses);
  slider.setAttribute('aria-valuetext', head);
  told.replaceChildren(element(head, 'h3'), ...paragraphs.map((text) => element(text, 'p')));
  told.style.borderColor = shown > 0 ? data.steps[Math.ceil(shown / 2) - 1].colour : 'transparent';
};
const pause = () => {
  clearInterval(timer);
  timer = null;
  play.textContent = 'Play';
  told.setAttribute('aria-live', 'polite');
};
const start = () => {
  if (shown >= last) show(0);
  play.textContent = 'Pause';
  told.setAttribute('aria-live', 'off');
  timer = setInterval(() => {
    show(shown + 1);
    if (shown >= last) pause();
  }, 500);
};

// Without WebGL the page says so, and shows the picture.
if (view.isPossible) {
  play.addEventListener('click', () => (timer === null ? start() : pause()));
  slider.addEventListener('input', () => { pause(); show(Number(slider.value)); });
  const steps = { PageUp: -1, PageDown: 1 };
  canvas.addEventListener('keydown', (event) => {
    if (!(event.key in steps)) return;
    event.preventDefault();
    pause();
    show(shown + steps[event.key]);
  });
  section.hidden = false;
  absence.hidden = true;
  show(last);
}
