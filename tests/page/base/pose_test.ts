import {expect, test} from "vitest";

import {
  aboutAxis,
  angleBetween,
  mixPose,
  multiply,
  norm,
  normalised,
  type Quat,
  rotate,
  subtract,
  type Vec3,
} from "@page/base/pose";

/// By the textbook's matrix, written out: independent of the code's formula.
function byMatrix([w, x, y, z]: Quat, v: Vec3): Vec3 {
  return [
    (1 - 2 * (y * y + z * z)) * v[0] + 2 * (x * y - w * z) * v[1] + 2 * (x * z + w * y) * v[2],
    2 * (x * y + w * z) * v[0] + (1 - 2 * (x * x + z * z)) * v[1] + 2 * (y * z - w * x) * v[2],
    2 * (x * z - w * y) * v[0] + 2 * (y * z + w * x) * v[1] + (1 - 2 * (x * x + y * y)) * v[2],
  ];
}

const kTurns: readonly Quat[] = [
  [1, 0, 0, 0],
  [0.5, 0.5, 0.5, 0.5],
  normalised([0.3, -0.2, 0.9, 0.1]),
  normalised([-0.7, 0.1, 0.4, -0.6]),
];

test("a quaternion turns a vector as its matrix does, and a product by its right factor first", () => {
  const v: Vec3 = [0.3, -1.2, 2];
  for (const a of kTurns) {
    expect(norm(subtract(rotate(a, v), byMatrix(a, v)))).toBeLessThan(1e-14);
    for (const b of kTurns)
      expect(norm(subtract(rotate(multiply(a, b), v), rotate(a, rotate(b, v))))).toBeLessThan(
        1e-14,
      );
  }
});

test("half way between two poses is half way in place and turn, the shorter way round", () => {
  const from = {p: [0, 0, 0] as Vec3, q: [1, 0, 0, 0] as Quat};
  const quarter = aboutAxis([0, 1, 0], Math.PI / 2);
  const to = {p: [2, 4, 6] as Vec3, q: quarter.map((value) => -value) as unknown as Quat};
  const middle = mixPose(from, to, 0.5);
  expect(middle.p).toEqual([1, 2, 3]);
  expect(angleBetween(middle.q, from.q)).toBeCloseTo(Math.PI / 4, 12);
  expect(angleBetween(middle.q, to.q)).toBeCloseTo(Math.PI / 4, 12);
  expect(Math.hypot(...middle.q)).toBeCloseTo(1, 12);
});
