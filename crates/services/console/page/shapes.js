// The triangles of items: fetched when they are first wanted, and kept.

import { bounds } from './vectors.js';

// A browser opens six connections to an address. Events have one, a step and an explanation may have one each: the rest is for a hold.
const MOST_AT_ONCE = 2;
const MOST_KEPT = 512;
const RETRY_MS = 3000;

/** The mesh in the bytes of a shape; null where they are none. */
export const parse = (bytes) => {
  if (bytes.byteLength < 8) return null;
  const view = new DataView(bytes);
  const [vertices, count] = [view.getUint32(0, true), view.getUint32(4, true)];
  if (bytes.byteLength !== 8 + 12 * (vertices + count)) return null;
  // Processors that run browsers have the low byte first, as the bytes do.
  const positions = new Float32Array(bytes, 8, 3 * vertices);
  const triangles = new Uint32Array(bytes, 8 + 12 * vertices, 3 * count);
  if (triangles.some((vertex) => vertex >= vertices)) return null;
  return { positions, triangles, ...bounds(positions) };
};

export class Shapes {
  /** `changed()` is called when a shape has come. */
  constructor(changed) {
    Object.assign(this, { changed, kept: new Map(), failed: new Map(), waiting: new Map(), fetching: 0 });
  }

  /** The mesh of a shape of a cell, or null until it has come. */
  get(cell, id) {
    if (!id) return null;
    const key = `${cell}/${id}`;
    const mesh = this.kept.get(key);
    if (mesh) return mesh;
    if (performance.now() - (this.failed.get(key) ?? -Infinity) > RETRY_MS) this.want(key, cell, id);
    return null;
  }

  /** Whether there is nothing to draw of a shape, and not only because it has not come yet. */
  isUnknown(cell, id) {
    return !id || this.failed.has(`${cell}/${id}`);
  }

  want(key, cell, id) {
    if (this.waiting.has(key)) return;
    this.waiting.set(key, () => this.fetch(key, cell, id));
    this.pump();
  }

  pump() {
    for (const [key, fetchIt] of this.waiting) {
      if (this.fetching >= MOST_AT_ONCE) return;
      if (fetchIt === null) continue;
      this.waiting.set(key, null);
      this.fetching += 1;
      fetchIt();
    }
  }

  async fetch(key, cell, id) {
    let mesh = null;
    try {
      const answer = await fetch(`api/cells/${encodeURIComponent(cell)}/shapes/${encodeURIComponent(id)}`);
      mesh = answer.ok ? parse(await answer.arrayBuffer()) : null;
    } catch {
      // Asked for again later, as one that is not known.
    }
    this.fetching -= 1;
    this.waiting.delete(key);
    if (mesh) this.keep(key, mesh);
    else this.fail(key);
    this.pump();
  }

  fail(key) {
    if (this.failed.size >= MOST_KEPT) this.failed.clear();
    this.failed.set(key, performance.now());
  }

  keep(key, mesh) {
    this.failed.delete(key);
    if (this.kept.size >= MOST_KEPT) this.kept.delete(this.kept.keys().next().value);
    this.kept.set(key, mesh);
    this.changed();
  }
}

// No orange among them: that is the choice.
const PALETTE = [
  [0.36, 0.58, 0.84], [0.42, 0.70, 0.46], [0.80, 0.44, 0.56], [0.56, 0.48, 0.80], [0.28, 0.68, 0.70],
  [0.72, 0.66, 0.34], [0.72, 0.50, 0.76], [0.50, 0.60, 0.66], [0.62, 0.72, 0.40], [0.40, 0.50, 0.72],
];

/** The colour of an item, always the same: red, green and blue. */
export const colourOf = (itemId) => {
  let hash = 7;
  for (const letter of itemId) hash = (hash * 31 + letter.codePointAt(0)) >>> 0;
  return PALETTE[((hash ^ (hash >>> 7)) >>> 0) % PALETTE.length];
};

export const css = (colour) => `rgb(${colour.map((part) => Math.round(part * 255)).join(' ')})`;
