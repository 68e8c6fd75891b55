// Vectors of three numbers, and matrices of sixteen as WebGL wants them: column after column.

export const subtract = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const unit = (a) => {
  const length = Math.hypot(...a) || 1;
  return [a[0] / length, a[1] / length, a[2] / length];
};

export const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

export const multiply = (a, b) => {
  const product = new Array(16).fill(0);
  for (let entry = 0; entry < 16; entry += 1) {
    for (let inner = 0; inner < 4; inner += 1) {
      product[entry] += a[4 * inner + (entry % 4)] * b[4 * Math.floor(entry / 4) + inner];
    }
  }
  return product;
};

/** Where a matrix takes a point, without what perspective does. */
export const transform = (matrix, [x, y, z]) =>
  [0, 1, 2].map((row) => matrix[row] * x + matrix[4 + row] * y + matrix[8 + row] * z + matrix[12 + row]);

/** The matrix of a pose: a position in metres and an orientation as a unit quaternion, w last. */
export const fromPose = ({ position_m: [x, y, z], orientation: [i, j, k, w] }) => [
  1 - 2 * (j * j + k * k), 2 * (i * j + k * w), 2 * (i * k - j * w), 0,
  2 * (i * j - k * w), 1 - 2 * (i * i + k * k), 2 * (j * k + i * w), 0,
  2 * (i * k + j * w), 2 * (j * k - i * w), 1 - 2 * (i * i + j * j), 0,
  x, y, z, 1,
];

/** The matrix that turns by an angle about z, and then moves. */
export const turnedAndMoved = (yaw_rad, [x, y, z]) => {
  const [c, s] = [Math.cos(yaw_rad), Math.sin(yaw_rad)];
  return [c, s, 0, 0, -s, c, 0, 0, 0, 0, 1, 0, x, y, z, 1];
};

/** The lowest and the highest corner of points, three numbers each, where a matrix takes them. */
export const bounds = (positions, matrix = identity) => {
  const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  for (let at = 0; at < positions.length; at += 3) {
    const point = transform(matrix, [positions[at], positions[at + 1], positions[at + 2]]);
    for (let axis = 0; axis < 3; axis += 1) {
      low[axis] = Math.min(low[axis], point[axis]);
      high[axis] = Math.max(high[axis], point[axis]);
    }
  }
  return { low, high };
};

/** The corners of the convex hull of points of a plane, counter-clockwise. */
export const hull = (points) => {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const turnsRight = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) <= 0;
  const half = (from) => {
    const side = [];
    for (const point of from) {
      while (side.length > 1 && turnsRight(side.at(-2), side.at(-1), point)) side.pop();
      side.push(point);
    }
    return side.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
};
