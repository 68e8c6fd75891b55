// What the cell does, in a sentence, and what has to be done where something has.

import { byId, setText, svg } from './dom.js';
import { span } from './format.js';

const LEVELS = {
  placing: 'going', planning: 'going', manual: 'going', waiting: 'idle', ended: 'idle', idle: 'idle', held: 'held', failed: 'stopped',
  unknown: 'stopped',
};

// One shape for each level, so that none is told by its colour alone.
const SIGNS = {
  going: ['M6 3.5v17l14-8.5z'],
  idle: ['M12 2.5a9.5 9.5 0 1 0 0 19 9.5 9.5 0 0 0 0-19zm0 2.4a7.1 7.1 0 1 1 0 14.2 7.1 7.1 0 0 1 0-14.2z', 'M10.8 6.5h2.4v5.2l3.6 2.2-1.2 2-4.8-3z'],
  held: ['M5 3h5v18H5z', 'M14 3h5v18h-5z'],
  stopped: ['M8 2h8l6 6v8l-6 6H8l-6-6V8zm2.9 4 .3 8h1.6l.3-8zm.1 9.6v2.2h2v-2.2z'],
};

/**
 * What is to be said: a level, a sentence, and what to do. `fault` is what went wrong in the page itself or null, `contact` that of the
 * connection, `silence` its silence in ms, `status` the part of the cell or null, and `hasCell` whether there is a cell.
 */
export const summary = ({ fault, contact, silence, status, hasCell }) => {
  if (fault) return { level: 'stopped', said: 'This page has a fault: what it shows may be old', advice: `Reload it. (${fault})` };
  if (contact === 'lost') {
    const last = status ? ` Last known: ${status.text}` : '';
    return {
      level: 'stopped', said: `No contact with the console for ${span(silence)}`,
      advice: `What is shown is old. It is tried again without end. To stop the robot, use the cell's own stop.${last}`,
    };
  }
  if (contact === 'connecting') return { level: 'idle', said: 'Connecting to the console', advice: '' };
  if (!hasCell) return { level: 'stopped', said: 'No cell is there', advice: 'Start the services, or look at their connection.' };
  if (!status) return { level: 'idle', said: 'Nothing was heard of this cell yet', advice: '' };
  const { doing, text, help, stale } = status;
  if (stale.length === 0) return { level: LEVELS[doing] ?? 'idle', said: text, advice: help ?? '' };
  const [first, ...others] = stale;
  const last = doing === 'unknown' ? null : `Last known: ${text}`;
  return { level: 'stopped', said: first, advice: [help, ...others, last].filter(Boolean).join(' ') };
};

/** Whether what is shown is as it is now. */
export const isCurrent = ({ fault, contact, status }) => !fault && contact === 'live' && (status?.stale.length ?? 0) === 0;

/** What is read out: without numbers that grow each second. */
const announced = ({ said, advice }) => `${said} ${advice}`.trim().replaceAll(/ ((since|for) )?\d+ (s|min|h|d)\b( \d+ min)?( ago)?/g, '');

let readOut = '';

/** Shows a summary; a screen reader is told once of each. */
export const showStatus = (told) => {
  const { level, said, advice } = told;
  const section = byId('status');
  if (section.dataset.level !== level || !byId('sign').firstChild) {
    section.dataset.level = level;
    byId('sign').replaceChildren(...SIGNS[level].map((d) => svg('path', { d, fill: 'currentColor', 'fill-rule': 'evenodd' })));
  }
  setText(byId('said'), said);
  setText(byId('advice'), advice);
  document.title = said;
  const text = announced(told);
  if (text !== readOut) setText(byId('announced'), text);
  readOut = text;
};

/** Shows whether what is seen is current. */
export const showContact = ({ fault, contact, silence, status }) => {
  const chip = byId('contact');
  const [level, text] = {
    connecting: ['idle', 'Connecting'],
    lost: ['stopped', `Not current: no contact for ${span(silence)}`],
    live: fault || status?.stale.length ? ['held', 'Not current'] : ['going', 'Live'],
  }[contact];
  chip.dataset.level = level;
  setText(chip, text);
  document.body.dataset.current = String(isCurrent({ fault, contact, status }));
};
