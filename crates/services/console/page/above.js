// The heights in the container as they are seen from above.

import { byId, setText } from './dom.js';
import { centimetres } from './format.js';
import { CHOSEN } from './scene.js';
import { css } from './shapes.js';
import { hull, transform } from './vectors.js';

// Dark to light, in equal steps for the eye; told apart without colours too.
const RAMP = [[38, 30, 74], [54, 74, 130], [43, 118, 142], [38, 158, 131], [104, 196, 92], [226, 223, 70]];

// So that the tops of boxes are seen below the surface that covers them.
const LIFT_M = 0.001;

const coloured = (share) => {
  const at = Math.max(0, Math.min(1, share)) * (RAMP.length - 1);
  const below = Math.min(RAMP.length - 2, Math.floor(at));
  return RAMP[below].map((part, channel) => Math.round(part + (RAMP[below + 1][channel] - part) * (at - below)));
};

/** The heights of a heightmap in units, cell (x, y) at x * ny + y; null where the text is no such thing. */
export const heights = ({ nx, ny, heights: text }) => {
  try {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    return bytes.length === 2 * nx * ny ? new Uint16Array(bytes.buffer) : null;
  } catch {
    return null;
  }
};

/**
 * The heights as a surface of steps, as corners of triangles for the scene, of at most 64 cells along each side: of more, the highest
 * of each block counts. What was not seen is left out.
 */
export const surface = (map, all) => {
  const block = Math.ceil(Math.max(map.nx, map.ny) / 64);
  const [nx, ny] = [Math.ceil(map.nx / block), Math.ceil(map.ny / block)];
  const tops = new Float32Array(nx * ny);
  for (let x = 0; x < map.nx; x += 1) {
    for (let y = 0; y < map.ny; y += 1) {
      const height = all[x * map.ny + y];
      const at = Math.floor(x / block) * ny + Math.floor(y / block);
      if (height <= map.rim_units) tops[at] = Math.max(tops[at], height * map.height_unit_m);
    }
  }
  const wide = block * map.cell_m;
  const made = [];
  const quad = (a, b, c, d, normal) => [a, b, c, a, c, d].forEach((corner) => made.push(corner[0], corner[1], corner[2] + LIFT_M, ...normal));
  for (let x = 0; x < nx; x += 1) {
    for (let y = 0; y < ny; y += 1) {
      const z = tops[x * ny + y];
      const [x0, y0, x1, y1] = [x * wide, y * wide, Math.min((x + 1) * wide, map.size_m[0]), Math.min((y + 1) * wide, map.size_m[1])];
      if (z > 0) quad([x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z], [0, 0, 1]);
      const right = x + 1 < nx ? tops[(x + 1) * ny + y] : z;
      if (right !== z) quad([x1, y0, z], [x1, y1, z], [x1, y1, right], [x1, y0, right], [1, 0, 0]);
      const behind = y + 1 < ny ? tops[x * ny + y + 1] : z;
      if (behind !== z) quad([x0, y1, z], [x1, y1, z], [x1, y1, behind], [x0, y1, behind], [0, 1, 0]);
    }
  }
  return new Float32Array(made);
};

export class AboveView {
  constructor(canvas) {
    Object.assign(this, { canvas, map: null, all: null, outline: null, pointed: null });
    byId('above-ramp').style.background = `linear-gradient(to right, ${RAMP.map((stop) => `rgb(${stop.join(' ')})`).join(', ')})`;
    canvas.addEventListener('pointermove', (event) => this.point(event));
    canvas.addEventListener('pointerdown', (event) => this.point(event));
    canvas.addEventListener('pointerleave', () => this.read(null));
    canvas.addEventListener('keydown', (event) => this.step(event));
    canvas.addEventListener('blur', () => this.read(null));
    new ResizeObserver(() => requestAnimationFrame(() => this.paint())).observe(canvas);
  }

  /** A heightmap, with its heights; and what is planned there (a mesh and its matrix), or null. */
  show(map, all, planned) {
    this.map = map;
    this.all = all;
    this.outline = planned && this.outlineOf(planned);
    if (map) {
      this.canvas.style.aspectRatio = `${map.size_m[0]} / ${map.size_m[1]}`;
      setText(byId('above-most'), `rim, ${centimetres(map.size_m[2])}`);
    }
    this.paint();
    this.read(this.pointed);
  }

  outlineOf({ mesh, matrix }) {
    const points = [];
    for (let at = 0; at < mesh.positions.length; at += 3) points.push(transform(matrix, mesh.positions.subarray(at, at + 3)));
    return hull(points);
  }

  paint() {
    const { canvas, map, all } = this;
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * scale));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * scale));
    if (!map || !all) return;
    const context = canvas.getContext('2d');
    context.imageSmoothingEnabled = false;
    context.drawImage(this.cells(), 0, 0, canvas.width, canvas.height);
    if (this.outline) this.trace(context, scale);
    if (this.pointed) this.mark(context, scale);
  }

  /** A picture of one pixel for each cell: x to the right, y upwards. */
  cells() {
    const { map, all } = this;
    const small = document.createElement('canvas');
    [small.width, small.height] = [map.nx, map.ny];
    const context = small.getContext('2d');
    const image = context.createImageData(map.nx, map.ny);
    for (let x = 0; x < map.nx; x += 1) {
      for (let y = 0; y < map.ny; y += 1) {
        const height = all[x * map.ny + y];
        const isHatched = (x + y) % 4 < 2;
        const unseen = isHatched ? [150, 150, 150] : [90, 90, 90];
        const colour = height > map.rim_units ? unseen : coloured(height / map.rim_units);
        image.data.set([...colour, 255], 4 * ((map.ny - 1 - y) * map.nx + x));
      }
    }
    context.putImageData(image, 0, 0);
    return small;
  }

  trace(context, scale) {
    const { canvas, map } = this;
    const [across, up] = [canvas.width / map.size_m[0], canvas.height / map.size_m[1]];
    context.beginPath();
    this.outline.forEach(([x, y]) => context.lineTo(x * across, canvas.height - y * up));
    context.closePath();
    [['#000', 5], [css(CHOSEN), 2.5]].forEach(([colour, width]) => {
      context.strokeStyle = colour;
      context.lineWidth = width * scale;
      context.stroke();
    });
  }

  mark(context, scale) {
    const { canvas, map, pointed } = this;
    const [wide, high] = [canvas.width / map.nx, canvas.height / map.ny];
    const size = Math.max(wide, 8 * scale);
    context.strokeStyle = '#fff';
    context.lineWidth = 2 * scale;
    context.strokeRect((pointed.x + 0.5) * wide - size / 2, canvas.height - (pointed.y + 0.5) * high - size / 2, size, size);
  }

  point(event) {
    if (!this.map) return;
    const box = this.canvas.getBoundingClientRect();
    const x = Math.floor(((event.clientX - box.left) / box.width) * this.map.nx);
    const y = Math.floor((1 - (event.clientY - box.top) / box.height) * this.map.ny);
    this.read({ x, y });
  }

  step(event) {
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!by || !this.map || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    const pace = Math.max(1, Math.round(this.map.nx / 32));
    const from = this.pointed ?? { x: Math.floor(this.map.nx / 2), y: Math.floor(this.map.ny / 2) };
    this.read({ x: from.x + by[0] * pace, y: from.y + by[1] * pace });
  }

  /** Says how high it is at a cell, or how to ask for it. */
  read(cell) {
    const { map, all } = this;
    const had = this.pointed;
    this.pointed = cell && map && {
      x: Math.max(0, Math.min(map.nx - 1, cell.x)), y: Math.max(0, Math.min(map.ny - 1, cell.y)),
    };
    setText(byId('above-note'), this.pointed && all ? this.said(this.pointed) : 'x to the right, y up, from the lower left corner. Point at a place to read its height.');
    if (had || this.pointed) this.paint();
  }

  said({ x, y }) {
    const { map, all } = this;
    const height = all[x * map.ny + y];
    const place = `x ${centimetres((x + 0.5) * map.cell_m)}, y ${centimetres((y + 0.5) * map.cell_m)}`;
    return height > map.rim_units ? `${place}: not seen` : `${place}: ${centimetres(height * map.height_unit_m)} high`;
  }
}
