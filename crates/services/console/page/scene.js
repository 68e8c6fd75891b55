// The container in three dimensions: what lies there, what is placed next, and where else it could have gone.

import { camera, corners, flat, Renderer } from './gl.js';
import { firstView, orbit } from './orbit.js';
import { cross, dot, subtract, transform } from './vectors.js';

/** The choice: no item has this colour. */
export const CHOSEN = [0.95, 0.56, 0.12];
const EDGE = [0.5, 0.55, 0.6, 1];
// Along x, y and z from the corner that positions count from; as in style.css.
const AXES = [[0.8, 0.2, 0.2, 1], [0.15, 0.55, 0.25, 1], [0.2, 0.4, 0.85, 1]];
// So that they are seen above the floor.
const LIFT_M = 0.001;
const FLOOR = [0.55, 0.6, 0.66, 0.3];
const RUNNER_UP = [0.2, 0.5, 0.9];
const SURFACE = [0.55, 0.6, 0.66, 0.45];

const ring = (z, [x0, y0], [x1, y1]) => [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]];
const around = (points) => points.flatMap((point, at) => [point, points[(at + 1) % 4]]);

/** The edges of a box, as pairs of points. */
const boxEdges = (low, high) => {
  const [below, above] = [ring(low[2], low, high), ring(high[2], low, high)];
  return [...around(below), ...around(above), ...below.flatMap((point, side) => [point, above[side]])];
};

/** How far along a ray it meets a mesh that lies as the matrix says; infinite where it does not. */
const meets = ({ from, along }, mesh, matrix) => {
  const at = (index) => transform(matrix, mesh.positions.subarray(3 * index, 3 * index + 3));
  let nearest = Infinity;
  for (let triangle = 0; triangle < mesh.triangles.length; triangle += 3) {
    const [a, b, c] = [0, 1, 2].map((side) => at(mesh.triangles[triangle + side]));
    const [one, other] = [subtract(b, a), subtract(c, a)];
    const across = cross(along, other);
    const area = dot(one, across);
    if (Math.abs(area) < 1e-15) continue;
    const to = subtract(from, a);
    const u = dot(to, across) / area;
    const around = cross(to, one);
    const v = dot(along, around) / area;
    const distance = dot(other, around) / area;
    if (u >= 0 && v >= 0 && u + v <= 1 && distance > 0) nearest = Math.min(nearest, distance);
  }
  return nearest;
};

export class SceneView {
  /** `picked(body)` hears of the item that was tapped, null for none. */
  constructor(canvas, picked) {
    Object.assign(this, { canvas, picked, view: firstView(), uploaded: new Map(), content: null, isDue: false });
    this.renderer = Renderer.on(canvas);
    if (!this.renderer) return;
    this.controls = orbit(canvas, this.view, () => this.redraw(), (x, y) => this.pick(x, y));
    canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    canvas.addEventListener('webglcontextrestored', () => {
      this.uploaded.clear();
      this.renderer.prepare();
      this.show(this.content);
    });
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  get isPossible() {
    return this.renderer !== null;
  }

  /**
   * What is seen, null for nothing, where the canvas is to be hidden: `size_m`; `bodies`, `planned` (or null) and `runnersUp`, each with
   * `mesh`, `matrix` and `colour`; and `surface`, corners of triangles, or null.
   */
  show(content) {
    this.content = content;
    if (!this.renderer || !content) return;
    this.fixed?.forEach((shape) => this.renderer.free(shape));
    const [floor, top] = [ring(0, [0, 0], content.size_m), content.size_m];
    this.floor = this.renderer.upload(flat([floor[0], floor[1], floor[2], floor[0], floor[2], floor[3]]));
    this.edges = this.renderer.upload(flat(boxEdges([0, 0, 0], top)));
    this.surface = content.surface && this.renderer.upload(content.surface);
    const lines = [[[0, 0, LIFT_M], [top[0], 0, LIFT_M]], [[0, 0, LIFT_M], [0, top[1], LIFT_M]], [[0, 0, 0], [0, 0, top[2]]]];
    this.axes = lines.map((line) => this.renderer.upload(flat(line)));
    this.fixed = [this.floor, this.edges, this.surface, ...this.axes].filter(Boolean);
    this.forget();
    this.redraw();
  }

  /** Frees what is shown no more. */
  forget() {
    const { bodies, planned, runnersUp } = this.content;
    const used = new Set([...bodies, planned, ...runnersUp].filter(Boolean).map(({ mesh }) => mesh));
    for (const [mesh, shapes] of this.uploaded) {
      if (used.has(mesh)) continue;
      Object.values(shapes).forEach((shape) => this.renderer.free(shape));
      this.uploaded.delete(mesh);
    }
  }

  shapesOf(mesh) {
    let shapes = this.uploaded.get(mesh);
    if (!shapes) {
      shapes = { faces: this.renderer.upload(corners(mesh)), box: this.renderer.upload(flat(boxEdges(mesh.low, mesh.high))) };
      this.uploaded.set(mesh, shapes);
    }
    return shapes;
  }

  redraw() {
    if (this.isDue || !this.content) return;
    this.isDue = true;
    requestAnimationFrame(() => {
      this.isDue = false;
      if (this.content) this.paint();
    });
  }

  camera() {
    const { size_m } = this.content;
    const { canvas, view } = this;
    const centre = size_m.map((length) => length / 2);
    return camera({ ...view, centre, radius: Math.hypot(...size_m) / 2, aspect: canvas.width / canvas.height });
  }

  paint() {
    const { canvas, renderer, content } = this;
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * scale));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * scale));
    renderer.begin(canvas.width, canvas.height, this.camera());
    renderer.triangles(this.floor, FLOOR, { isLit: false });
    // Before the edges that they lie on.
    this.axes.forEach((axis, at) => renderer.lines(axis, AXES[at]));
    renderer.lines(this.edges, EDGE);
    content.bodies.forEach((body) => {
      const shapes = this.shapesOf(body.mesh);
      renderer.triangles(shapes.faces, [...body.colour, 1], { matrix: body.matrix });
      if (body.isMarked) renderer.lines(shapes.box, [...CHOSEN, 1], body.matrix);
    });
    content.runnersUp.forEach((other) => {
      const shapes = this.shapesOf(other.mesh);
      renderer.lines(shapes.box, [...RUNNER_UP, 1], other.matrix);
      renderer.triangles(shapes.faces, [...RUNNER_UP, other.isChosen ? 0.7 : 0.2], { matrix: other.matrix, isGhost: !other.isChosen });
    });
    if (content.planned) {
      const shapes = this.shapesOf(content.planned.mesh);
      renderer.lines(shapes.box, [...CHOSEN, 1], content.planned.matrix);
      renderer.triangles(shapes.faces, [...CHOSEN, 1], { matrix: content.planned.matrix });
    }
    if (this.surface) renderer.triangles(this.surface, SURFACE);
  }

  /** Which item is seen at a place of the canvas. */
  pick(x, y) {
    if (!this.content) return;
    const { eye, right, above, back, focal, aspect } = this.camera();
    const [across, up] = [((2 * x - 1) * aspect) / focal, (1 - 2 * y) / focal];
    const along = back.map((part, axis) => -part + across * right[axis] + up * above[axis]);
    const ray = { from: eye, along };
    const candidates = [...this.content.bodies, this.content.planned].filter(Boolean);
    const far = candidates.map((body) => meets(ray, body.mesh, body.matrix));
    const nearest = Math.min(...far);
    this.picked(Number.isFinite(nearest) ? candidates[far.indexOf(nearest)] : null);
  }
}
