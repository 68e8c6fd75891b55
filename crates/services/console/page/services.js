// The services and how they are.

import { byId, make, redraw, setText, table } from './dom.js';
import { span } from './format.js';

const health = (service) => {
  if (!service.is_alive) return ['bad', 'gone'];
  return service.is_ready ? ['good', 'ready'] : ['mild', 'not ready'];
};

const row = ({ service, instance, version, health: [kind, text], failing, since }) => make(
  'tr', { 'data-service': instance },
  make('th', { scope: 'row' }, service, make('div', { class: 'soft small' }, version ? `${instance}, ${version}` : instance)),
  make('td', {}, make('span', { class: `tag ${kind}` }, text), ...failing.map((told) => make('div', { class: 'small' }, told))),
  make('td', { class: 'n' }, since),
);

/** Shows the services that serve a cell, or any; those in trouble first. */
export const showServices = (services, cell, containers, now) => {
  const served = [cell, ...containers];
  const mine = (services ?? []).filter(({ cells }) => cells.length === 0 || cells.some((name) => served.includes(name)));
  const rank = (service) => (service.is_alive ? Number(service.is_ready) + 1 : 0);
  const ordered = [...mine].sort((a, b) => rank(a) - rank(b) || a.service.localeCompare(b.service) || a.instance.localeCompare(b.instance));
  const since = (service) => (now ? span(now - service.since_ms) : '');
  const rows = ordered.map((service) => ({ ...service, uptime_s: null, health: health(service), since: since(service) }));
  const ready = mine.filter((service) => service.is_alive && service.is_ready).length;
  setText(byId('serving-count'), `${ready} of ${mine.length} ready`);
  redraw(byId('serving'), rows, () => {
    if (rows.length === 0) return make('p', { class: 'soft' }, 'No service is there.');
    return table([['Service', null], ['State', null], ['Since', 'n']], rows.map(row));
  });
};
