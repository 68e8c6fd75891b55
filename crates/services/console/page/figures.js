// How full the container is over the session, and how long steps take.

import { barChart, lineChart, rounded } from './charts.js';
import { byId, make, redraw } from './dom.js';
import { clock, milliseconds, percent, seconds } from './format.js';

const MOST_BARS = 60;

const figure = (name, told) => make('div', {}, make('dt', {}, name), make('dd', {}, told));

/** Shows how full a container is. */
export const showFilled = (figures) => redraw(byId('filled'), figures, () => {
  if (!figures || figures.utilisation === null) return make('p', { class: 'soft' }, 'Nothing is known yet.');
  const { utilisation, filled, items, items_without_volume: unknown, history } = figures;
  const points = history.map(([at, value]) => ({ at, value }));
  const most = Math.min(1, rounded(Math.max(0.1, ...points.map(({ value }) => value))));
  const label = `The container's volume that is filled over the session, now ${percent(utilisation)}`;
  const [first, last] = [points.at(0), points.at(-1)].map((point) => (point ? clock(point.at) : ''));
  return [
    make(
      'dl', { class: 'figures' },
      figure('of the volume', `${unknown > 0 ? 'at least ' : ''}${percent(utilisation)}`), figure('items', String(items)),
      filled !== null && figure('below the surface', percent(filled)),
    ),
    lineChart(points, { most, format: (share) => `${Math.round(share * 100)} %`, label, first, last }),
    unknown > 0 && make('p', { class: 'soft small' }, `The volume of ${unknown} of them is not known and not counted.`),
  ];
});

/** Shows how long the steps of a session took. */
export const showCycles = (cycles) => redraw(byId('cycles'), cycles, () => {
  const steps = (cycles?.steps ?? []).slice(-MOST_BARS);
  if (steps.length === 0) return make('p', { class: 'soft' }, 'No step was made yet.');
  const { mean_took_s: mean, mean_cycle_s: planned } = cycles;
  const [first, last] = [steps[0], steps.at(-1)].map(({ step }) => `step ${step + 1}`);
  const took = steps.map((step) => step.took_s ?? null);
  const most = rounded(Math.max(0.1, mean ?? 0, ...took.map((value) => value ?? 0)));
  const lastTook = took.findLast((value) => value !== null) ?? null;
  const label = `Seconds from decision to outcome of ${steps.length} steps${mean === null ? '' : `, ${seconds(mean)} in the mean`}`;
  return [
    make(
      'dl', { class: 'figures' },
      lastTook !== null && figure('last', seconds(lastTook)), mean !== null && figure('mean', seconds(mean)),
      planned !== null && figure('planned for the arm', seconds(planned)), figure('to decide, last', milliseconds(steps.at(-1).plan_ms)),
    ),
    barChart(took, { most, format: seconds, label, mean, first, last }),
  ];
});
