// What happened, the newest first.

import { byId, make, redraw } from './dom.js';
import { clock } from './format.js';

const LEVELS = { info: ['', 'info'], warning: ['tag mild', 'warning'], error: ['tag bad', 'error'] };

const line = ({ at_ms: at, level, text, number }) => {
  const [kind, name] = LEVELS[level] ?? LEVELS.info;
  return make(
    'li', { 'data-event': number },
    make('time', { datetime: new Date(at).toISOString() }, clock(at)),
    make('span', {}, make('span', { class: kind || 'soft' }, name)),
    make('span', {}, text),
  );
};

/** Shows the events of a cell. */
export const showEvents = (events) => redraw(byId('happened'), events, () => {
  if (!events || events.length === 0) return make('p', { class: 'soft' }, 'Nothing happened yet.');
  return make('ol', { class: 'events' }, ...[...events].reverse().map(line));
});
