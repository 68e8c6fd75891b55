// Plays a packing step by step: the container and its items in WebGL, a slider, and what each step decided. The slider has two
// positions a step: its item as planned, and everything as it lay then.
'use strict';
(() => {
  const section = document.getElementById('playback');
  const canvas = section.querySelector('canvas');
  const gl = canvas.getContext('webgl', { antialias: true, alpha: true });
  if (!gl) return; // The page says so, and shows the picture.
  const data = JSON.parse(document.getElementById('playback-data').textContent);
  const [width, depth, height] = data.container_m;
  const centre = [width / 2, depth / 2, height / 2];
  const radius = Math.hypot(width, depth, height) / 2;

  // Shapes: base64 of 16-bit numbers, the low byte first.
  const numbers = (text) => {
    const bytes = atob(text);
    const all = new Uint16Array(bytes.length / 2);
    for (let at = 0; at < all.length; at += 1) {
      all[at] = bytes.charCodeAt(2 * at) | (bytes.charCodeAt(2 * at + 1) << 8);
    }
    return all;
  };
  const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const unit = (a) => { const length = Math.hypot(...a) || 1; return a.map((part) => part / length); };

  // Corners with the normal of their triangle, so that every face is flat.
  const corners = (mesh) => {
    const steps = numbers(mesh.vertices);
    const triangles = numbers(mesh.triangles);
    const vertex = (index) => [0, 1, 2].map((axis) => mesh.lowest_m[axis] + steps[3 * index + axis] * mesh.step_m);
    const all = new Float32Array(triangles.length * 6);
    for (let at = 0; at < triangles.length; at += 3) {
      const triangle = [vertex(triangles[at]), vertex(triangles[at + 1]), vertex(triangles[at + 2])];
      const normal = unit(cross(subtract(triangle[1], triangle[0]), subtract(triangle[2], triangle[0])));
      triangle.forEach((corner, side) => all.set([...corner, ...normal], (at + side) * 6));
    }
    return all;
  };
  const buffer = (content) => {
    const made = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.bufferData(gl.ARRAY_BUFFER, content, gl.STATIC_DRAW);
    return { made, count: content.length / 6 };
  };
  const up = [0, 0, 1];
  const flat = (points) => new Float32Array(points.flatMap((point) => [...point, ...up]));
  const rim = (z) => [[0, 0, z], [width, 0, z], [width, depth, z], [0, depth, z]];
  const around = (ring) => ring.flatMap((point, at) => [point, ring[(at + 1) % 4]]);
  const [low, high] = [rim(0), rim(height)];

  const compiled = (kind, source) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    return shader;
  };
  const program = gl.createProgram();
  gl.attachShader(program, compiled(gl.VERTEX_SHADER, `
    attribute vec3 at; attribute vec3 normal;
    uniform mat4 clip_from_world; uniform mat4 world_from_item;
    varying vec3 facing; varying vec3 place;
    void main() {
      vec4 world = world_from_item * vec4(at, 1.0);
      facing = mat3(world_from_item) * normal;
      place = world.xyz;
      gl_Position = clip_from_world * world;
    }`));
  gl.attachShader(program, compiled(gl.FRAGMENT_SHADER, `
    precision mediump float;
    uniform vec4 colour; uniform float lit; uniform vec3 eye;
    varying vec3 facing; varying vec3 place;
    void main() {
      float slope = abs(dot(normalize(facing), normalize(eye - place)));
      float above = 0.5 + 0.5 * abs(normalize(facing).z);
      float light = mix(1.0, 0.35 + 0.45 * slope + 0.25 * above, lit);
      gl_FragColor = vec4(colour.rgb * light, 1.0) * colour.a;
    }`));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return;
  gl.useProgram(program);
  const uniform = (name) => gl.getUniformLocation(program, name);
  const [clipFromWorld, worldFromItem, colourOf, lit, eyeAt] =
    ['clip_from_world', 'world_from_item', 'colour', 'lit', 'eye'].map(uniform);
  const [at, normalAt] = ['at', 'normal'].map((name) => gl.getAttribLocation(program, name));
  gl.enableVertexAttribArray(at);
  gl.enableVertexAttribArray(normalAt);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);

  const models = data.models.map((mesh) => buffer(corners(mesh)));
  const floor = buffer(flat([low[0], low[1], low[2], low[0], low[2], low[3]]));
  const edges = buffer(flat([...around(low), ...around(high), ...low.flatMap((point, side) => [point, high[side]])]));
  const channels = (hex) => [1, 3, 5].map((from) => parseInt(hex.slice(from, from + 2), 16) / 255);

  // Matrices are columns, as WebGL wants them.
  const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];
  const matrix = (pose) => {
    const [x, y, z, ...turn] = pose.map((whole) => whole / 1e4);
    const [w, i, j, k] = unit(turn);
    return [
      1 - 2 * (j * j + k * k), 2 * (i * j + k * w), 2 * (i * k - j * w), 0,
      2 * (i * j - k * w), 1 - 2 * (i * i + k * k), 2 * (j * k + i * w), 0,
      2 * (i * k + j * w), 2 * (j * k - i * w), 1 - 2 * (i * i + j * j), 0,
      x, y, z, 1,
    ];
  };
  const multiply = (a, b) => {
    const product = new Array(16).fill(0);
    for (let entry = 0; entry < 16; entry += 1) {
      for (let inner = 0; inner < 4; inner += 1) {
        product[entry] += a[4 * inner + (entry % 4)] * b[4 * Math.floor(entry / 4) + inner];
      }
    }
    return product;
  };
  const items = data.steps.map((step) => ({ model: models[step.model], colour: channels(step.colour) }));

  // What is to be seen at a position of the slider: where each item lies, and what that step placed or moved.
  const last = 2 * data.steps.length;
  const scene = (position) => {
    const done = Math.floor(position / 2);
    const poses = new Map();
    data.steps.slice(0, done).forEach((step) => {
      step.gone.forEach((item) => poses.delete(item));
      step.shifts.forEach(({ item, pose }) => poses.set(item, matrix(pose)));
    });
    if (position % 2 === 0) {
      return { poses, now: new Set(done > 0 ? data.steps[done - 1].shifts.map(({ item }) => item) : []) };
    }
    const { planned } = data.steps[done];
    if (planned) poses.set(done, matrix(planned));
    return { poses, now: new Set([done]) };
  };

  // The view: an orbit around the container, which begins where the picture was taken.
  const view = { azimuth: -2.14, elevation: 0.71, zoom: 1 };
  let shown = last;
  let drawn = scene(shown);
  const camera = () => {
    const away = (2.25 * radius) / view.zoom;
    const [azimuth, elevation] = [view.azimuth, view.elevation];
    const back = [Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation), Math.sin(elevation)];
    const eye = centre.map((along, axis) => along + away * back[axis]);
    const right = unit(cross(up, back));
    const above = cross(back, right);
    const look = [
      right[0], above[0], back[0], 0, right[1], above[1], back[1], 0, right[2], above[2], back[2], 0,
      -dot(right, eye), -dot(above, eye), -dot(back, eye), 1,
    ];
    const aspect = canvas.width / canvas.height;
    const focal = 1.6 * Math.min(1, aspect * 1.1);
    const [near, far] = [radius * 0.05, away + radius * 6];
    const lens = [
      focal / aspect, 0, 0, 0, 0, focal, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0,
    ];
    return { matrix: multiply(lens, look), eye };
  };
  const draw = (kind, shape, pose, colour, shading) => {
    gl.bindBuffer(gl.ARRAY_BUFFER, shape.made);
    gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 24, 0);
    gl.vertexAttribPointer(normalAt, 3, gl.FLOAT, false, 24, 12);
    gl.uniformMatrix4fv(worldFromItem, false, pose);
    gl.uniform4fv(colourOf, colour);
    gl.uniform1f(lit, shading);
    gl.drawArrays(kind, 0, shape.count);
  };
  const faded = (colour) => colour.map((channel) => 0.45 * channel + 0.55 * 0.72);
  const paint = () => {
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * scale));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * scale));
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const seen = camera();
    gl.uniformMatrix4fv(clipFromWorld, false, seen.matrix);
    gl.uniform3fv(eyeAt, seen.eye);
    draw(gl.TRIANGLES, floor, identity, [0.55, 0.6, 0.66, 0.35], 0);
    draw(gl.LINES, edges, identity, [0.5, 0.55, 0.6, 1], 0);
    drawn.poses.forEach((pose, item) => {
      const { model, colour } = items[item];
      if (model) draw(gl.TRIANGLES, model, pose, [...(drawn.now.has(item) ? colour : faded(colour)), 1], 1);
    });
  };
  let isDue = false;
  const redraw = () => {
    if (isDue) return;
    isDue = true;
    requestAnimationFrame(() => { isDue = false; paint(); });
  };

  // The steps.
  const slider = section.querySelector('input');
  const play = section.querySelector('.play');
  const now = section.querySelector('.now');
  const paragraph = (text, kind) => {
    const made = document.createElement(kind);
    made.textContent = text;
    return made;
  };
  const told = (position) => {
    if (position === 0) return ['Before the first step', 'The container is empty.'];
    const number = Math.ceil(position / 2);
    const step = data.steps[number - 1];
    const isPlanned = position % 2 === 1;
    const head = `Step ${number} of ${data.steps.length}: ${step.item}${isPlanned ? ', as planned' : ''}`;
    if (isPlanned) return [head, step.decided];
    if (!items[number - 1].model) return [head, step.became, 'Its shape is not known, and not drawn.'];
    const isThere = drawn.poses.has(number - 1);
    return [head, step.became, ...(isThere ? [] : ['It is not in the container, and not drawn.'])];
  };
  const show = (position) => {
    shown = Math.max(0, Math.min(last, position));
    drawn = scene(shown);
    slider.value = String(shown);
    const [head, ...texts] = told(shown);
    slider.setAttribute('aria-valuetext', head);
    now.replaceChildren(paragraph(head, 'h3'), ...texts.map((text) => paragraph(text, 'p')));
    now.style.borderColor = shown > 0 ? data.steps[Math.ceil(shown / 2) - 1].colour : 'transparent';
    redraw();
  };
  let timer = null;
  const pause = () => {
    clearInterval(timer);
    timer = null;
    play.textContent = 'Play';
    now.setAttribute('aria-live', 'polite');
  };
  const start = () => {
    if (shown >= last) show(0);
    play.textContent = 'Pause';
    now.setAttribute('aria-live', 'off');
    timer = setInterval(() => {
      show(shown + 1);
      if (shown >= last) pause();
    }, 500);
  };
  play.addEventListener('click', () => (timer === null ? start() : pause()));
  slider.addEventListener('input', () => { pause(); show(Number(slider.value)); });

  // Turning and zooming by pointers, wheel and keys.
  const turn = (azimuth, elevation) => {
    view.azimuth += azimuth;
    view.elevation = Math.max(-0.2, Math.min(1.55, view.elevation + elevation));
    redraw();
  };
  const zoom = (factor) => {
    view.zoom = Math.max(0.5, Math.min(6, view.zoom * factor));
    redraw();
  };
  const pointers = new Map();
  const spread = () => {
    const [one, other] = [...pointers.values()];
    return Math.hypot(one[0] - other[0], one[1] - other[1]) || 1;
  };
  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const apart = pointers.size === 2 ? spread() : null;
    pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (apart !== null) zoom(spread() / apart);
    else if (pointers.size === 1) turn((before[0] - event.clientX) * 0.008, (event.clientY - before[1]) * 0.008);
  });
  ['pointerup', 'pointercancel'].forEach((kind) => canvas.addEventListener(kind, (event) => pointers.delete(event.pointerId)));
  canvas.addEventListener('wheel', (event) => {
    if (document.activeElement !== canvas) return; // The page scrolls until the view is chosen.
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * 0.001));
  }, { passive: false });
  const keys = {
    ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, 0.1), ArrowDown: () => turn(0, -0.1),
    '+': () => zoom(1.15), '=': () => zoom(1.15), '-': () => zoom(1 / 1.15),
    PageUp: () => { pause(); show(shown - 1); }, PageDown: () => { pause(); show(shown + 1); },
  };
  canvas.addEventListener('keydown', (event) => {
    const act = keys[event.key];
    if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    act();
  });

  canvas.addEventListener('webglcontextlost', () => {
    pause();
    section.hidden = true;
    document.getElementById('no-playback').hidden = false;
  });
  section.hidden = false;
  document.getElementById('no-playback').hidden = true;
  new ResizeObserver(redraw).observe(canvas);
  show(last);
})();
