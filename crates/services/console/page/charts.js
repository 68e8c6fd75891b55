// Small charts as SVG, with what they show as text.

import { svg } from './dom.js';

const size = { width: 420, height: 150, left: 40, right: 10, top: 10, bottom: 24 };
const plot = { width: size.width - size.left - size.right, height: size.height - size.top - size.bottom };

/** The least of 1, 2 and 5 times a power of ten that is no less. */
export const rounded = (value) => {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].map((times) => times * power).find((limit) => limit >= value * (1 - 1e-9));
};

const down = (share) => size.top + plot.height * (1 - share);
const across = (share) => size.left + plot.width * share;

/** Lines and numbers for values from 0 to `most`; below them what the first and the last one are. */
const axes = (most, format, first, last) => {
  const values = [0, 0.5, 1].flatMap((share) => [
    svg('line', { class: 'grid', x1: size.left, x2: size.width - size.right, y1: down(share), y2: down(share) }),
    svg('text', { x: size.left - 6, y: down(share) + 4, 'text-anchor': 'end' }, format(share * most)),
  ]);
  const foot = size.height - 6;
  return [
    ...values,
    svg('text', { x: size.left, y: foot }, first),
    svg('text', { x: size.width - size.right, y: foot, 'text-anchor': 'end' }, last),
  ];
};

const picture = (label, ...children) =>
  svg('svg', { viewBox: `0 0 ${size.width} ${size.height}`, role: 'img', 'aria-label': label, class: 'chart' }, ...children);

/**
 * What stays as it is until it changes, as a line of steps. `points` is a list of `{ at, value }` by increasing time, with a gap from
 * one whose value is null, `most` the end of the scale, `format` makes its numbers texts, `first` and `last` say when the ends are.
 */
export const lineChart = (points, { most, format, label, first, last }) => {
  const [from, to] = [points[0]?.at ?? 0, points.at(-1)?.at ?? 0];
  const places = points.map(({ at, value }) => ({
    x: across(to > from ? (at - from) / (to - from) : 0).toFixed(1), y: value === null ? null : down(Math.min(1, value / most)).toFixed(1),
  }));
  const drawn = (begin, end) => places.map(({ x, y }, at) => {
    const before = places[at - 1]?.y ?? null;
    if (before === null) return y === null ? '' : begin(x, y);
    return y === null ? `H${x}${end}` : `H${x}V${y}`;
  }).join('');
  const steps = drawn((x, y) => `M${x} ${y}`, '');
  const area = drawn((x, y) => `M${x} ${down(0)}V${y}`, `V${down(0)}`);
  const end = places.findLast(({ y }) => y !== null);
  return picture(
    label,
    ...axes(most, format, first, last),
    end && svg('path', { class: 'area', d: `${area}V${down(0)}` }),
    end && svg('path', { class: 'line', d: steps }),
    end && svg('circle', { class: 'dot', cx: end.x, cy: end.y, r: 4 }),
  );
};

/** A bar for each value; one that is null leaves a gap. The mean, where there is one, is a line across. */
export const barChart = (values, { most, format, label, mean, first, last }) => {
  const wide = plot.width / Math.max(12, values.length);
  const bars = values.map((value, at) => {
    if (value === null) return null;
    const top = down(Math.min(1, value / most));
    const x = size.left + (at + 0.1) * wide;
    const height = Math.max(0, down(0) - top);
    return svg('rect', { class: 'bar', x: x.toFixed(1), y: top.toFixed(1), width: (wide * 0.8).toFixed(1), height: height.toFixed(1) });
  });
  const level = mean === null ? null : down(Math.min(1, mean / most));
  return picture(
    label,
    ...axes(most, format, first, last),
    ...bars,
    level !== null && svg('line', { class: 'mean', x1: size.left, x2: size.width - size.right, y1: level, y2: level }),
  );
};
