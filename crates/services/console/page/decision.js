// The last decision: what goes where, what else there was, and why other items were refused.

import { byId, make, redraw, setText, table } from './dom.js';
import { centimetres, degrees, kilograms, milliseconds, named, seconds, span, words } from './format.js';

const OUTCOMES = {
  placed: ['good', 'placed'],
  not_placed: ['mild', 'not placed: the item is where it was'],
  lost: ['bad', 'lost'],
  unknown: ['bad', 'not known'],
};

const value = (number) => number.toFixed(3);

/** Where the lowest corner of an item's box is, in words. */
export const placed = ({ corner_m: corner, yaw_rad: yaw }) => {
  if (!corner) return 'the place is not known';
  const [x, y, z] = corner.map(centimetres);
  return `x ${x}, y ${y}, ${z} above the floor${yaw === null ? '' : `, turned by ${degrees(yaw)}`}`;
};

const fact = (name, ...told) => [make('dt', {}, name), make('dd', {}, ...told)];

const settled = ({ tilt_rad: tilt, slide_m: slide, disturbance_m: moves }) =>
  `tilts ${degrees(tilt)}, slides ${centimetres(slide)}, moves others ${centimetres(moves)}`;

const facts = (decision, isOneOfSeveral, isUnderWay) => {
  const { outcome, settling, load } = decision;
  const others = [...decision.degraded, ...(decision.is_widened ? ['nothing proposed was valid: all was searched'] : [])];
  const without = decision.is_given_up ? 'given up: it is not carried out' : 'not heard of';
  const [kind, text] = OUTCOMES[outcome?.kind] ?? ['mild', isUnderWay ? 'under way' : without];
  const stages = decision.stages.map(({ stage, ms }) => `${words(stage)} ${milliseconds(ms)}`).join(', ');
  return make(
    'dl', { class: 'facts' },
    ...fact('Outcome', make('span', { class: `tag ${kind}` }, text), outcome?.text ? ` ${outcome.text}` : ''),
    ...fact('Where', `${isOneOfSeveral ? `${decision.container}: ` : ''}${placed(decision)}`),
    ...fact('Value', `${value(decision.value)} (lower is better)`),
    ...fact('Decided in', `${milliseconds(decision.plan_ms)}${stages ? `: ${stages}` : ''}`),
    ...(decision.cycle_s === null ? [] : fact('Arm', `${seconds(decision.cycle_s)} planned`)),
    ...(settling ? fact('When tried', settled(settling)) : []),
    ...(load ? fact('Rests on', `${load.item_id}: ${kilograms(load.estimated_kg)} of ${kilograms(load.carries_kg)} that it may carry`) : []),
    ...(others.length ? fact('Otherwise than set', others.join('; ')) : []),
  );
};

/** A table of the runners-up; the one that has the pointer or the focus is shown in the container. */
const runnersUp = (decision, point) => {
  if (decision.alternatives.length === 0) return make('p', { class: 'soft small' }, 'No other placement was given.');
  const rows = decision.alternatives.map((other, at) => {
    const name = other.item_id === decision.item_id ? 'same item' : named(other.object);
    const shown = make('button', { type: 'button', class: 'plain', 'data-key': `runner ${at}`, 'aria-pressed': 'false' }, name);
    const row = make(
      'tr', {},
      make('th', { scope: 'row' }, shown),
      make('td', {}, placed(other)),
      make('td', { class: 'n' }, `${value(other.value)} (+${value(other.value - decision.value)})`),
    );
    const set = (isOn) => {
      shown.setAttribute('aria-pressed', String(isOn));
      point(isOn ? { decision: decision.decision_id, at } : null);
    };
    row.addEventListener('pointerenter', (event) => event.pointerType === 'mouse' && set(true));
    row.addEventListener('pointerleave', (event) => event.pointerType === 'mouse' && set(false));
    shown.addEventListener('focus', () => set(true));
    shown.addEventListener('blur', () => set(false));
    return row;
  });
  return table([['Item', null], ['Where', null], ['Value', 'n']], rows, { class: 'runners' });
};

const refused = (others) => table([['Item', null], ['Why not', null]], others.map((other) => make(
  'tr', {},
  make('th', { scope: 'row' }, named(other.object), make('div', { class: 'soft small' }, other.item_id)),
  make('td', {}, other.text || words(other.reason)),
)));

/**
 * Shows the newest decision. `point(runnerUp)` hears which runner-up is looked at, by the id of the decision and
 * its index; null for none.
 */
export const showDecision = (decisions, session, now, point) => {
  const decision = decisions?.[0] ?? null;
  setText(byId('last-when'), decision && now ? `step ${decision.step + 1}, ${span(now - decision.at_ms)} ago` : '');
  const others = decision ? [...decision.others, ...(session?.reasons ?? [])] : session?.reasons ?? [];
  const told = others.filter((other, at) => others.findIndex(({ item_id: id }) => id === other.item_id) === at);
  const isUnderWay = decision !== null && decision.decision_id === session?.pending;
  redraw(byId('last'), [decision, told, isUnderWay], () => [
    decision === null && make('p', { class: 'soft' }, 'Nothing was decided yet.'),
    decision && make('p', { class: 'chosen-item' }, make('b', {}, named(decision.object)), ` ${decision.item_id}`),
    decision && facts(decision, (session?.containers.length ?? 0) > 1, isUnderWay),
    decision && make('h3', {}, 'Next best placements'),
    decision && runnersUp(decision, point),
    (decision || told.length > 0) && make('h3', {}, 'Items that were refused'),
    told.length > 0 ? refused(told) : decision && make('p', { class: 'soft small' }, 'None that anything is known of.'),
  ]);
};
