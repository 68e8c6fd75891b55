// What lies in the container, as a list: the picture for those who do not see it, and where an item is named as removed.

import { placed } from './decision.js';
import { byId, make, redraw, setText } from './dom.js';
import { centimetres, degrees, items, kilograms, named } from './format.js';
import { colourOf, css } from './shapes.js';

const found = ({ is_inside: isInside, inspection }) => {
  if (!isInside) return ['bad', 'outside'];
  if (!inspection) return null;
  const { kind, slide_m: slide, tilt_rad: tilt, reason } = inspection;
  const told = {
    as_planned: ['good', 'as planned'], moved: ['mild', `moved by ${centimetres(slide)}`], toppled: ['bad', `toppled by ${degrees(tilt)}`],
    missing: ['bad', 'missing'], unclear: ['mild', `not seen clearly${reason ? `: ${reason}` : ''}`],
  };
  return told[kind] ?? null;
};

const row = (item, isLast, removed) => {
  const told = found(item);
  return make(
    'tr', { 'data-item': item.item_id },
    make('th', { scope: 'row' }, swatch(item.item_id), named(item.object), make('div', { class: 'soft small' }, item.item_id)),
    make(
      'td', {},
      isLast && make('span', { class: 'tag chosen' }, 'last'), ' ',
      told && make('span', { class: `tag ${told[0]}` }, told[1]),
      make('div', { class: 'soft small' }, where(item)),
      item.load && make('div', { class: 'soft small' }, loads(item.load)),
    ),
    removed && make('td', { class: 'n' }, removal(item, removed)),
  );
};

/** Where an item lies, in words: as a decision says it. */
export const where = ({ corner_m }) => placed({ corner_m, yaw_rad: null });

const loads = ({ item_id: id, estimated_kg: load, carries_kg: limit }) => `loads ${id} with ${kilograms(load)} of ${kilograms(limit)}`;

const removal = (item, removed) => {
  const label = `${named(item.object)} ${item.item_id} was removed`;
  return make('button', { type: 'button', 'data-key': `removed ${item.item_id}`, 'aria-label': label, onclick: () => removed(item) }, 'Removed');
};

export const swatch = (itemId) => {
  const made = make('span', { class: 'swatch', 'aria-hidden': 'true' });
  made.style.background = css(colourOf(itemId));
  return made;
};

/** The items of a container, the last one first. */
export const ordered = (all) => [...all].sort((a, b) => (b.step ?? -1) - (a.step ?? -1));

/** Shows the items of a container, the last one first; `removed(item)` is the act of taking one out of the account, or null. */
export const showContents = (all, last, removed) => {
  setText(byId('inside-count'), all ? items(all.length) : '');
  redraw(byId('inside'), [all, last, removed !== null], () => {
    if (!all || all.length === 0) return make('p', { class: 'soft' }, all ? 'It is empty.' : 'Nothing is known of it.');
    return make('table', {}, make('tbody', {}, ...ordered(all).map((item) => row(item, item.item_id === last, removed))));
  });
};
