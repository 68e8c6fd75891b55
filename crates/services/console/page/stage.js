// What stands in the picture of the container, from what is known of it.

import { CHOSEN } from './scene.js';
import { colourOf } from './shapes.js';
import { bounds, fromPose, turnedAndMoved } from './vectors.js';

/** Where a shape lies that is turned about z, with the lowest corner of its box at a place. */
const atCorner = (mesh, { yaw_rad: yaw, corner_m: corner }) => {
  const { low } = bounds(mesh.positions, turnedAndMoved(yaw, [0, 0, 0]));
  return turnedAndMoved(yaw, corner.map((along, axis) => along - low[axis]));
};

const lowest = new WeakMap();

/** The lowest corner of the box of an item that lies; null where its shape or its place is not known. */
export const lowestOf = (item, shape) => {
  const mesh = lowest.has(item) ? null : shape(item.shape);
  if (mesh && item.container_from_shape) lowest.set(item, bounds(mesh.positions, fromPose(item.container_from_shape)).low);
  return lowest.get(item) ?? null;
};

const lies = (mesh, placement) => {
  if (placement.container_from_shape) return fromPose(placement.container_from_shape);
  return placement.corner_m && placement.yaw_rad !== null ? atCorner(mesh, placement) : null;
};

const body = (item, shape, colour) => {
  const mesh = shape(item.shape);
  const matrix = mesh && lies(mesh, item);
  return matrix && { mesh, matrix, colour, itemId: item.item_id, object: item.object };
};

/**
 * The picture of a container; null where its size is not known. `decided` is the decision under way, if any, `decision` the last one
 * that is of this container, `last` the item that was placed last, `picked` the one that was tapped, `shape(id)` its mesh or null, and
 * `runnerUp` the one that is looked at (a decision's id and an index), or null.
 */
export const content = ({ map, items, decision, decided, last, picked, shape, showsRunnersUp, runnerUp }) => {
  if (!map) return null;
  const lying = items.map((item) => {
    const made = body(item, shape, colourOf(item.item_id));
    return made && { ...made, isMarked: item.item_id === (picked ?? (decided === null ? last : null)) };
  });
  const bodies = lying.filter(Boolean);
  const isPlanned = decision !== null && decision.decision_id === decided?.decision_id;
  const planned = isPlanned ? body(decision, shape, CHOSEN) : null;
  const runnersUp = (decision?.alternatives ?? []).map((other, at) => {
    const isChosen = runnerUp?.decision === decision.decision_id && runnerUp.at === at;
    const made = showsRunnersUp || isChosen ? body(other, shape, CHOSEN) : null;
    return made && { ...made, isChosen };
  }).filter(Boolean);
  const key = [
    items.map((item) => [item.item_id, item.container_from_shape]), bodies.length, bodies.map(({ isMarked }) => isMarked),
    planned && decision.decision_id, runnersUp.length && decision?.decision_id, runnersUp.length, runnerUp,
  ];
  return { size_m: map.size_m, bodies, planned, runnersUp, key };
};
