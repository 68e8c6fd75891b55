// Draws flat shaded meshes, and lines, with WebGL. Knows nothing of containers.

import { cross, dot, identity, multiply, subtract, unit } from './vectors.js';

const VERTEX = `
  attribute vec3 at; attribute vec3 normal;
  uniform mat4 clip_from_world; uniform mat4 world_from_model;
  varying vec3 facing; varying vec3 place;
  void main() {
    vec4 world = world_from_model * vec4(at, 1.0);
    facing = mat3(world_from_model) * normal;
    place = world.xyz;
    gl_Position = clip_from_world * world;
  }`;

const FRAGMENT = `
  precision mediump float;
  uniform vec4 colour; uniform float lit; uniform vec3 eye;
  varying vec3 facing; varying vec3 place;
  void main() {
    float slope = abs(dot(normalize(facing), normalize(eye - place)));
    float above = 0.5 + 0.5 * abs(normalize(facing).z);
    float light = mix(1.0, 0.35 + 0.45 * slope + 0.25 * above, lit);
    gl_FragColor = vec4(colour.rgb * light, 1.0) * colour.a;
  }`;

/** The corners of all triangles, each with the normal of its triangle, so that every face is flat. */
export const corners = ({ positions, triangles }) => {
  const vertex = (index) => positions.subarray(3 * index, 3 * index + 3);
  const all = new Float32Array(triangles.length * 6);
  for (let at = 0; at < triangles.length; at += 3) {
    const triangle = [vertex(triangles[at]), vertex(triangles[at + 1]), vertex(triangles[at + 2])];
    const normal = unit(cross(subtract(triangle[1], triangle[0]), subtract(triangle[2], triangle[0])));
    triangle.forEach((corner, side) => {
      all.set(corner, (at + side) * 6);
      all.set(normal, (at + side) * 6 + 3);
    });
  }
  return all;
};

/** Points of lines or triangles that are not lit. */
export const flat = (points) => new Float32Array(points.flatMap((point) => [...point, 0, 0, 1]));

/**
 * A camera that looks at `centre` from a direction, so far away that a sphere of `radius` metres around it is in the picture.
 * Angles are in radians: the azimuth from x, counter-clockwise from above, and the elevation above the horizon.
 */
export const camera = ({ azimuth, elevation, zoom, centre, radius, aspect }) => {
  const away = (2.25 * radius) / zoom;
  const back = [Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation)];
  const eye = centre.map((along, axis) => along + away * back[axis]);
  const right = unit(cross([0, 0, 1], back));
  const above = cross(back, right);
  const look = [
    right[0], above[0], back[0], 0, right[1], above[1], back[1], 0, right[2], above[2], back[2], 0,
    -dot(right, eye), -dot(above, eye), -dot(back, eye), 1,
  ];
  const focal = 2.1 * Math.min(1, aspect);
  const [near, far] = [Math.max(radius * 0.02, away - radius * 3), away + radius * 6];
  const lens = [
    focal / aspect, 0, 0, 0, 0, focal, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0,
  ];
  return { matrix: multiply(lens, look), eye, right, above, back, focal, aspect };
};

const compiled = (gl, kind, source) => {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  return shader;
};

/** What draws on one canvas. */
export class Renderer {
  /** Null where the browser has no WebGL. */
  static on(canvas) {
    const gl = canvas.getContext('webgl', { antialias: true, alpha: true });
    return gl && new Renderer(gl);
  }

  constructor(gl) {
    this.gl = gl;
    this.prepare();
  }

  /** Makes anew what a lost context took; shapes have to be uploaded again. */
  prepare() {
    const { gl } = this;
    const program = gl.createProgram();
    gl.attachShader(program, compiled(gl, gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(program, compiled(gl, gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(program);
    gl.useProgram(program);
    const names = ['clip_from_world', 'world_from_model', 'colour', 'lit', 'eye'];
    this.uniforms = Object.fromEntries(names.map((name) => [name, gl.getUniformLocation(program, name)]));
    this.attributes = ['at', 'normal'].map((name) => gl.getAttribLocation(program, name));
    this.attributes.forEach((attribute) => gl.enableVertexAttribArray(attribute));
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  /** A shape of `corners` or `flat`, on the graphics card. */
  upload(content) {
    const { gl } = this;
    const made = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.bufferData(gl.ARRAY_BUFFER, content, gl.STATIC_DRAW);
    return { made, count: content.length / 6 };
  }

  free(shape) {
    this.gl.deleteBuffer(shape.made);
  }

  /** Clears a picture of so many pixels, which `seen` (a camera) looks at. */
  begin(width, height, seen) {
    const { gl, uniforms } = this;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(uniforms.clip_from_world, false, seen.matrix);
    gl.uniform3fv(uniforms.eye, seen.eye);
  }

  /** Draws triangles: `colour` is red, green, blue and opacity, `isLit` whether light falls on them, a ghost hides nothing. */
  triangles(shape, colour, { matrix = identity, isLit = true, isGhost = false } = {}) {
    this.gl.depthMask(!isGhost);
    this.draw(this.gl.TRIANGLES, shape, colour, matrix, isLit);
    this.gl.depthMask(true);
  }

  lines(shape, colour, matrix = identity) {
    this.draw(this.gl.LINES, shape, colour, matrix, false);
  }

  draw(kind, shape, colour, matrix, isLit) {
    const { gl, uniforms } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, shape.made);
    gl.vertexAttribPointer(this.attributes[0], 3, gl.FLOAT, false, 24, 0);
    gl.vertexAttribPointer(this.attributes[1], 3, gl.FLOAT, false, 24, 12);
    gl.uniformMatrix4fv(uniforms.world_from_model, false, matrix);
    gl.uniform4fv(uniforms.colour, colour);
    gl.uniform1f(uniforms.lit, isLit ? 1 : 0);
    gl.drawArrays(kind, 0, shape.count);
  }
}
