// The services and how they are.

import { byId, make, redraw, setText } from './dom.js';
import { span } from './format.js';

const health = (service) => {
  if (!service.is_alive) return ['bad', 'gone'];
  return service.is_ready ? ['good', 'ready'] : ['mild', 'not ready'];
};

/** Shows the services that serve a cell, or any; those in trouble first. */
export const showServices = (services, cell, containers, now) => {
  const served = [cell, ...containers];
  const mine = (services ?? []).filter(({ cells }) => cells.length === 0 || cells.some((name) => served.includes(name)));
  const rank = (service) => (service.is_alive ? Number(service.is_ready) + 1 : 0);
  const ordered = [...mine].sort((a, b) => rank(a) - rank(b) || a.service.localeCompare(b.service) || a.instance.localeCompare(b.instance));
  const rows = ordered.map((service) => ({ ...service, uptime_s: null, health: health(service), since: now ? span(now - service.since_ms) : '' }));
  const ready = mine.filter((service) => service.is_alive && service.is_ready).length;
  setText(byId('serving-count'), `${ready} of ${mine.length} ready`);
  redraw(byId('serving'), rows, () => {
    if (rows.length === 0) return make('p', { class: 'soft' }, 'No service is there.');
    return make(
      'table', {},
      make('thead', {}, make('tr', {}, ...['Service', 'State', 'Since'].map((name) => make('th', { scope: 'col', class: name === 'Since' ? 'n' : null }, name)))),
      make('tbody', {}, ...rows.map((service) => make(
        'tr', { 'data-service': service.instance },
        make('th', { scope: 'row' }, service.service, make('div', { class: 'soft small' }, `${service.instance}${service.version ? `, ${service.version}` : ''}`)),
        make('td', {}, make('span', { class: `tag ${service.health[0]}` }, service.health[1]), ...service.failing.map((text) => make('div', { class: 'small' }, text))),
        make('td', { class: 'n' }, service.since),
      ))),
    );
  });
};
