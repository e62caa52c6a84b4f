import {expect, test} from "vitest";

import type {Body, SceneModel} from "@page/model/bundle";
import {axisOf, firstSight} from "@page/model/first_sight";
import {add, aboutAxis, norm, type Pose, rotate, subtract, type Vec3} from "@page/base/pose";

import {box} from "../support/scene_bytes";

/// A rod of 120 mm from its end at the origin along +y, 4 mm thick.
const kRod = Array.from({length: 61}, (_, i) =>
  [-2, 2].flatMap((x) => [-2, 2].flatMap((z) => [x, 2 * i, z])),
)
  .flat()
  .map((mm) => 1e-3 * mm);

const body = (name: string, vertices: readonly number[], pose: Pose): Body =>
  ({
    name,
    pose,
    geometry: {vertices: Float32Array.from(vertices), centre: [0, 0.06, 0], radiusM: 0.0601},
  }) as unknown as Body;

const kSight = {centre: [0, 0, 0] as Vec3, radiusM: 0.02, from: [0, 0, 1] as Vec3};
const rodAt = (pose: Pose): SceneModel =>
  ({
    tools: [body("rod", kRod, pose)],
    objects: [],
    firstSight: kSight,
  }) as unknown as SceneModel;

/// Between the sight and the rod's direction, whichever way round [degrees].
const angle = (from: Vec3, q: Pose["q"]): number => {
  const axis = rotate(q, [0, 1, 0]);
  const along = Math.abs(from[0] * axis[0] + from[1] * axis[1] + from[2] * axis[2]);
  return (180 / Math.PI) * Math.acos(Math.min(1, along));
};

test("the first sight holds the work and the tool's near end, wherever it starts", () => {
  for (const p of [
    [0, 0.05, 0],
    [0.1, 0, 0.02],
    [-0.03, 0.2, 0.4],
  ] as const) {
    const {centre, radiusM} = firstSight(rodAt({p, q: [1, 0, 0, 0]}), []);
    expect(norm(subtract(centre, kSight.centre)) + kSight.radiusM).toBeLessThanOrEqual(
      radiusM + 1e-9,
    );
    expect(norm(subtract(p, centre))).toBeLessThanOrEqual(radiusM + 3e-3); // half as thick
  }
  // And no more than that: 10 mm of the rod, whose other 110 are its handle.
  expect(firstSight(rodAt({p: [0, 0.05, 0], q: [1, 0, 0, 0]}), []).radiusM).toBeCloseTo(0.04, 3);
});

test("a tool is looked at where it is, not where it starts", () => {
  const model = rodAt({p: [0, 0.5, 0], q: [1, 0, 0, 0]});
  const {radiusM} = firstSight(model, [{p: [0, 0.01, 0], q: [1, 0, 0, 0]}]);
  expect(radiusM).toBeLessThan(0.03);
});

test("nobody looks along a tool", () => {
  // Exactly along it, nearly, and from its other end.
  for (const degrees of [90, 80, 110, -90]) {
    const q = aboutAxis([1, 0, 0], (degrees * Math.PI) / 180);
    const {from} = firstSight(rodAt({p: [0, 0, 0.05], q}), []);
    expect(norm(from)).toBeCloseTo(1);
    expect(angle(from, q)).toBeGreaterThan(34.9);
    expect(from[2]).toBeGreaterThan(0.5); // and still from the front
  }
});

test("a sight that sees a tool from its side stays as the scene has it", () => {
  expect(firstSight(rodAt({p: [0, 0.05, 0], q: [1, 0, 0, 0]}), []).from).toEqual([0, 0, 1]);
});

test("a tool that is about as thick as long has no direction", () => {
  const q: Pose["q"] = [1, 0, 0, 0];
  expect(axisOf(body("box", box(0.05).vertices, {p: [0, 0, 0], q}))).toBeUndefined();
  const axis = axisOf(body("rod", kRod, {p: [0, 0, 0], q}))!;
  expect(Math.abs(axis[1])).toBeCloseTo(1);
  expect(norm(add(axis, [0, 0, 0]))).toBeCloseTo(1);
});
