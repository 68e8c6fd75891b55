// The items that wait, with pictures of them.

import { tell } from './dialogs.js';
import { byId, make, redraw, setText } from './dom.js';
import { centimetres, items, kilograms, named } from './format.js';
import { camera, corners, Renderer } from './gl.js';
import { CHOSEN } from './scene.js';
import { colourOf } from './shapes.js';

const WIDTH = 240;
const HEIGHT = 180;
const MOST_KEPT = 256;

/** Pictures of meshes, all made by one canvas that is not shown: browsers allow few with WebGL. */
export class Pictures {
  constructor() {
    this.canvas = document.createElement('canvas');
    [this.canvas.width, this.canvas.height] = [WIDTH, HEIGHT];
    this.renderer = Renderer.on(this.canvas);
    this.kept = new Map();
    this.canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    this.canvas.addEventListener('webglcontextrestored', () => this.renderer.prepare());
  }

  /** Draws a mesh on a canvas of the page; leaves it empty where there is no mesh. */
  draw(target, mesh, colour) {
    [target.width, target.height] = [WIDTH, HEIGHT];
    const picture = mesh && this.renderer && this.picture(mesh, colour);
    if (picture) target.getContext('2d').drawImage(picture, 0, 0);
  }

  picture(mesh, colour) {
    const byColour = this.kept.get(mesh) ?? new Map();
    const key = colour.join();
    if (!byColour.has(key)) {
      if (this.kept.size >= MOST_KEPT) this.kept.delete(this.kept.keys().next().value);
      byColour.set(key, this.taken(mesh, colour));
      this.kept.set(mesh, byColour);
    }
    return byColour.get(key);
  }

  taken(mesh, colour) {
    const { renderer } = this;
    const centre = mesh.low.map((low, axis) => (low + mesh.high[axis]) / 2);
    const radius = Math.hypot(...mesh.low.map((low, axis) => mesh.high[axis] - low)) / 2;
    const shape = renderer.upload(corners(mesh));
    renderer.begin(WIDTH, HEIGHT, camera({ azimuth: -2.14, elevation: 0.6, zoom: 0.95, centre, radius, aspect: WIDTH / HEIGHT }));
    renderer.triangles(shape, [...colour, 1]);
    renderer.free(shape);
    const kept = document.createElement('canvas');
    [kept.width, kept.height] = [WIDTH, HEIGHT];
    kept.getContext('2d').drawImage(this.canvas, 0, 0);
    return kept;
  }
}

const rules = (item) => [
  item.is_fragile && 'fragile',
  item.is_bottom_only && 'on the floor only',
  item.is_upright && 'upright',
  item.carries_kg !== null && `carries ${kilograms(item.carries_kg)}`,
  item.order && `order ${item.order}`,
].filter(Boolean).join(', ');

const tags = (item, isChosen) => {
  if (isChosen) return make('span', { class: 'tag chosen' }, 'next');
  if (item.state === 'set_aside') return make('span', { class: 'tag mild' }, 'set aside');
  return item.is_choosable ? make('span', { class: 'tag good' }, 'can be chosen') : null;
};

/** Why an item did not go in, by the last decision and the session. */
export const reasonOf = (itemId, session, decisions) => {
  const told = [...(decisions?.[0]?.others ?? []), ...(session?.reasons ?? []), ...(session?.set_aside ?? [])];
  return told.find((other) => other.item_id === itemId)?.text ?? null;
};

/**
 * Shows the buffer of a cell. `context` has `buffer`, `session`, `decisions`, `chosen` (the id of the item that is placed, or null),
 * `shape(id)`, `pictures`, and the acts `explain(item)` and, or null, `withdraw(item)`.
 */
export const showBuffer = ({ buffer, session, decisions, chosen, shape, pictures, explain, withdraw }) => {
  const all = buffer?.items ?? [];
  const waiting = session ? session.counts.waiting + session.counts.decided : all.length;
  const most = buffer ? `; of the first ${buffer.limit} one is chosen` : '';
  setText(byId('waiting-count'), `${items(waiting)}${most}`);
  const cards = all.map((item) => ({
    ...item, isChosen: item.item_id === chosen, reason: reasonOf(item.item_id, session, decisions), has: shape(item.shape) !== null,
  }));
  redraw(byId('waiting'), [cards, buffer?.more ?? 0, withdraw !== null], () => {
    if (cards.length === 0) return make('p', { class: 'soft' }, 'No item waits.');
    const list = make('ul', { class: 'items' });
    cards.forEach((item) => list.append(card(item, { shape, pictures, explain, withdraw })));
    if (buffer.more > 0) list.append(make('li', { class: 'item soft' }, `and ${items(buffer.more)} more`));
    return list;
  });
};

const card = (item, { shape, pictures, explain, withdraw }) => {
  const canvas = make('canvas', { 'aria-hidden': 'true' });
  pictures.draw(canvas, shape(item.shape), item.isChosen ? CHOSEN : colourOf(item.item_id));
  const name = `${named(item.object)} ${item.item_id}`;
  const act = (text, label, done) =>
    make('button', { type: 'button', 'data-key': `${text} ${item.item_id}`, 'aria-label': label, onclick: () => done(item) }, text);
  const acts = make(
    'div', { class: 'card-acts' },
    item.is_choosable && !item.isChosen && act('Where?', `Where would ${name} go?`, explain),
    !item.isChosen && withdraw && act('Withdraw', `${name} is withdrawn: it does not come`, withdraw),
  );
  const told = rules(item);
  return make(
    'li', { class: 'item', 'data-state': item.isChosen ? 'chosen' : item.state, 'data-item': item.item_id },
    canvas,
    make('b', {}, named(item.object)),
    make('p', { class: 'soft' }, item.item_id),
    make('p', {}, tags(item, item.isChosen)),
    told && make('p', {}, told),
    item.reason && make('p', {}, item.reason),
    acts,
  );
};

/** Asks the planner where an item would go, and tells it. */
export const explain = async (cell, item) => {
  const title = `${named(item.object)} (${item.item_id})`;
  let isRead = false;
  tell(title, 'The planner is asked…').then(() => { isRead = true; });
  const { best, reason, counts, text } = await explanation(cell, item);
  // Who closed that wants no answer any more, and another question must not give way to it.
  if (isRead) return;
  const refusals = (counts?.refusals ?? []).map((refusal) => {
    const detail = refusal.detail ? ` (${refusal.detail})` : '';
    return make('li', {}, `${refusal.count}: ${refusal.text}${detail}`);
  });
  const place = best?.corner_m ? ` at x ${centimetres(best.corner_m[0])}, y ${centimetres(best.corner_m[1])}` : '';
  tell(
    title,
    best ? `It would go in${place}, with value ${best.value.toFixed(3)}.` : reason?.text ?? text ?? 'There was no answer.',
    ...(counts ? [`Of ${counts.possible} placements ${counts.fitting} fit.`, make('ul', {}, ...refusals)] : []),
  );
};

const explanation = async (cell, { item_id: id }) => {
  try {
    const address = `api/cells/${encodeURIComponent(cell)}/explain/${encodeURIComponent(id)}`;
    const answer = await fetch(address, { signal: AbortSignal.timeout(30000) });
    return await answer.json();
  } catch {
    return { text: 'There was no answer.' };
  }
};
