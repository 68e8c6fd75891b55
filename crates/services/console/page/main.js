// Puts the page together: what is heard is kept, and what has changed is drawn, at most once for each picture of the screen.

import { AboveView, heights, surface } from './above.js';
import { explain, Pictures, showBuffer } from './buffer.js';
import { Connection } from './connection.js';
import { showContents } from './contents.js';
import { Controls } from './controls.js';
import { showDecision } from './decision.js';
import { readyDialogs } from './dialogs.js';
import { byId, make, redraw, setText } from './dom.js';
import { showEvents } from './events.js';
import { showCycles, showFilled } from './figures.js';
import { items as counted, named, span } from './format.js';
import { readyKeys, readyTheme } from './preferences.js';
import { SceneView } from './scene.js';
import { showServices } from './services.js';
import { Shapes } from './shapes.js';
import { busiest, lastPlaced, pending, State } from './state.js';
import { showContact, showStatus, summary } from './status.js';
import { content, lowestOf } from './stage.js';

const state = new State();
const shapes = new Shapes(() => due());
const pictures = new Pictures();
const chosen = { cell: null, container: null, runnerUp: null, picked: null };
const seen = { map: null, all: null, surface: null, said: '' };
const scene = new SceneView(byId('scene'), (body) => {
  setText(byId('scene-note'), body ? `${named(body.object)} (${body.itemId}): the one that “Item removed” means` : HINT);
  chosen.picked = body?.itemId ?? null;
  due();
});
const NO_WEBGL = 'This browser has no WebGL: see the heights from above, and the list of what lies in the container.';
const HINT = 'Drag to turn, pinch to come closer, tap an item to name and to choose it.';
const above = new AboveView(byId('above'));
const controls = new Controls(where);
let fault = null;
const connection = new Connection('api/events', heard, due);

function heard(kind, data, at) {
  state[kind](data, at);
  due();
}

/** Which cell and container are shown, and what lies there. */
function where() {
  const cells = state.cells();
  const cell = cells.find(({ name }) => name === chosen.cell) ?? cells[0] ?? null;
  const container = cell && (cell.containers.includes(chosen.container) ? chosen.container : busiest(state, cell));
  const lying = (cell && state.value('items', cell.name, container)) ?? [];
  const items = lying.map((item) => ({ ...item, corner_m: lowestOf(item, (id) => shapes.get(cell.name, id)) }));
  const picked = items.some(({ item_id: id }) => id === chosen.picked) ? chosen.picked : null;
  return { cell: cell?.name ?? null, container, containers: cell?.containers ?? [], items, picked };
}

let isDue = false;
function due() {
  if (isDue) return;
  isDue = true;
  requestAnimationFrame(() => {
    isDue = false;
    show();
  });
}

function show() {
  const { cell, container, containers, items, picked } = where();
  const of = (part) => state.value(part, cell);
  const now = state.now(performance.now());
  const [status, session, decisions] = [of('status'), of('session'), of('decisions')];
  const told = { fault, contact: connection.contact, silence: connection.silence(), status, hasCell: cell !== null };
  showStatus(summary(told));
  showContact(told);
  controls.show(state.value('console'), status);
  showChoices(cell, containers);
  const decided = pending(session, decisions);
  showBuffer({
    buffer: of('buffer'), session, decisions, chosen: decided?.item_id ?? null, pictures,
    shape: (id) => shapes.get(cell, id),
    explain: (item) => explain(where().cell, item),
    withdraw: controls.isOff ? null : (item) => controls.withdraw(item),
  });
  showDecision(decisions, session, now, (runnerUp) => {
    chosen.runnerUp = runnerUp;
    due();
  });
  const last = lastPlaced(decisions, container);
  showContents(items, last, controls.isOff ? null : (item) => controls.askRemoved(item.item_id));
  showFilled(state.value('figures', cell, container));
  showCycles(of('cycles'));
  showServices(state.value('services'), cell, containers, now);
  showEvents(of('events'));
  showContainer({ cell, container, items, decision: decisions?.[0] ?? null, decided, last, picked, now });
}

/** The container, in three dimensions and from above. */
function showContainer({ cell, container, items, decision, decided, last, picked, now }) {
  const map = state.value('heightmap', cell, container);
  if (map !== seen.map) Object.assign(seen, { map, all: map && heights(map), surface: null });
  const stage = content({
    map, items, decision: decision?.container === container ? decision : null, decided, last, picked,
    shape: (id) => shapes.get(cell, id), showsRunnersUp: byId('show-runners').checked, runnerUp: chosen.runnerUp,
  });
  // What has no shape to draw is seen at least as a part of the surface.
  const isSurfaceWanted = byId('show-surface').checked || items.some((item) => shapes.isUnknown(cell, item.shape));
  if (map && seen.all && isSurfaceWanted) seen.surface ??= surface(map, seen.all);
  else seen.surface = null;
  const planned = stage?.planned ?? null;
  const shown = [container, stage?.key, map && [map.state_number, map.at_ms], seen.surface !== null];
  const said = JSON.stringify(shown);
  if (said !== seen.said) {
    seen.said = said;
    byId('scene').dataset.bodies = String(stage?.bodies.length ?? 0);
    scene.show(stage && { ...stage, surface: seen.surface });
    above.show(map, seen.all, planned);
    describe(container, items, planned, map);
  }
  byId('nothing-seen').hidden = map !== null;
  for (const canvas of [byId('scene'), byId('above')]) canvas.classList.toggle('empty', map === null);
  for (const id of ['above-legend', 'above-note']) byId(id).hidden = map === null;
  setText(byId('above-age'), map && now ? `unchanged for ${span(now - map.at_ms)}` : '');
  setText(byId('doubts'), map?.doubts.length ? `Not planned on: ${map.doubts.join('; ')}` : '');
}

function describe(container, items, planned, map) {
  const next = planned ? `; ${named(planned.object)} is placed next` : '';
  byId('scene').setAttribute('aria-label', `${container ?? 'The container'} in three dimensions: ${counted(items.length)}${next}`);
  const heightsOf = map ? `Heights in ${container} from above; arrows read them` : 'Heights from above: nothing was seen yet';
  byId('above').setAttribute('aria-label', heightsOf);
}

/** What can be chosen among: shown where there is more than one. */
function showChoices(cell, containers) {
  const options = (names, value) => names.map(([name, text]) => {
    const option = make('option', { value: name }, text);
    option.selected = name === value;
    return option;
  });
  const cells = state.cells().map(({ name }) => name);
  byId('cell-label').hidden = cells.length < 2;
  redraw(byId('cell'), [cells, cell], () => options(cells.map((name) => [name, name]), cell));
  byId('container-label').hidden = containers.length < 2;
  const follow = containers.includes(chosen.container) ? chosen.container : '';
  redraw(byId('container'), [containers, follow], () => options([['', 'where the robot is'], ...containers.map((name) => [name, name])], follow));
  setText(byId('title'), cell ?? 'Packing cell');
}

/** The choice of cell and container, kept in the address. */
function choose(cell, container) {
  Object.assign(chosen, { cell, container, runnerUp: null, picked: null });
  history.replaceState(null, '', `#${[cell, container].filter(Boolean).map(encodeURIComponent).join('/')}`);
  due();
}

/** The names in the address; none where somebody wrote something else there. */
function addressed() {
  try {
    return location.hash.slice(1).split('/').map(decodeURIComponent);
  } catch {
    return [];
  }
}

function readyPage() {
  [chosen.cell, chosen.container] = [...addressed(), '', ''].map((name) => name || null);
  readyTheme();
  readyDialogs();
  readyKeys({
    h: () => controls.act('hold'),
    r: () => controls.act('resume'),
    s: () => controls.act('step'),
    '?': () => byId('help').open || byId('help').showModal(),
  });
  byId('cell').addEventListener('change', (event) => choose(event.target.value, null));
  byId('container').addEventListener('change', (event) => choose(where().cell, event.target.value || null));
  for (const box of [byId('show-runners'), byId('show-surface')]) box.addEventListener('change', due);
  const views = {
    left: () => scene.controls.turn(-0.3, 0),
    right: () => scene.controls.turn(0.3, 0),
    in: () => scene.controls.zoom(1.3),
    out: () => scene.controls.zoom(1 / 1.3),
    reset: () => scene.controls.reset(),
  };
  for (const button of document.querySelectorAll('[data-view]')) button.addEventListener('click', () => views[button.dataset.view]());
  byId('view-keys').hidden = !scene.isPossible;
  setText(byId('scene-note'), scene.isPossible ? HINT : NO_WEBGL);
  // Nobody trusts a page that has stopped to draw.
  const failed = (what) => {
    fault = String(what);
    due();
  };
  window.addEventListener('error', (event) => event.error && failed(event.message));
  window.addEventListener('unhandledrejection', (event) => failed(event.reason));
  // Ages grow by themselves.
  setInterval(due, 500);
}

readyPage();
