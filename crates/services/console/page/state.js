// What the page knows: the newest value of each part, by the events of the stream. Nothing here touches the page or the network.

const keyOf = (cell, container, part) => JSON.stringify([cell, container, part]);

export class State {
  constructor() {
    this.parts = new Map();
    this.clock = null;
  }

  /** Everything anew: what was known before is forgotten. `at` is the page's clock in ms, as for all of these. */
  snapshot({ now_ms, parts }, at) {
    this.parts.clear();
    parts.forEach((part) => this.part(part));
    this.beat({ now_ms }, at);
  }

  part({ cell, container, part, value }) {
    this.parts.set(keyOf(cell, container, part), value);
  }

  beat({ now_ms }, at) {
    this.clock = { now_ms, at };
  }

  /** The server's clock now, in Unix milliseconds; null before anything was heard. */
  now(at) {
    return this.clock && this.clock.now_ms + (at - this.clock.at);
  }

  /** The value of a part, null where nothing was heard of it. */
  value(part, cell = null, container = null) {
    return this.parts.get(keyOf(cell, container, part)) ?? null;
  }

  cells() {
    return this.value('cells') ?? [];
  }
}

/** Of a cell's containers the one that was decided on last; else the first. */
export const busiest = (state, cell) => {
  const named = (state.value('decisions', cell.name) ?? [])[0]?.container;
  return cell.containers.includes(named) ? named : (cell.containers[0] ?? null);
};

/** The decision that awaits its outcome, or null. */
export const pending = (session, decisions) =>
  (decisions ?? []).find((decision) => decision.decision_id === session?.pending) ?? null;

/** The id of the item that was placed into a container last, or null. */
export const lastPlaced = (decisions, container) =>
  (decisions ?? []).find((decision) => decision.container === container && decision.outcome?.kind === 'placed')?.item_id ?? null;
