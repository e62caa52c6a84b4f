import {expect, test} from "vitest";

import type {Bur, SceneModel} from "@page/model/bundle";
import {
  aboutAxis,
  kIdentity,
  multiply,
  pointOf,
  type Pose,
  type Quat,
  type Vec3,
} from "@page/base/pose";
import {guardedM, usualGuards} from "@page/model/guarded";

import {box} from "../support/scene_bytes";

const kBall: Bur = {curve: [[0, 0.0007]], rounding: 0.0007};
const kCylinder: Bur = {
  curve: [
    [0, 0.0001],
    [0.0004, 0.0001],
    [0.0004, 0.004],
    [0, 0.004],
  ],
  rounding: 0.0001,
};
const meshOf = ({vertices, triangles}: ReturnType<typeof box>) => ({
  vertices: Float32Array.from(vertices),
  triangles: Uint32Array.from(triangles),
});
const scene = (region: object, pose: Pose = kIdentity): SceneModel =>
  ({
    objects: [
      {
        pose,
        tissues: ["enamel", "pulp"],
        regions: [{low: [0, 0, 0], high: [0, 0, 0], radiusM: 0, tissue: 1, ...region}],
      },
    ],
  }) as unknown as SceneModel;
const at = (p: Vec3, q = kIdentity.q): Pose => ({p, q});

test("a round bur's surface is as far from a ball as their radii leave", () => {
  const model = scene({low: [0.001, 0, 0], radiusM: 0.002});
  const above = (heightM: number): number =>
    guardedM(model, kBall, at([0.001, heightM - 0.0007, 0]), "pulp", 0.003);
  expect(above(0.0037)).toBeCloseTo(0.001, 9);
  expect(above(0.0027)).toBeCloseTo(0, 9);
  expect(above(0.002)).toBe(0);
  expect(above(0.006)).toBe(Infinity);
  expect(guardedM(model, kBall, at([0.001, 0.003, 0]), "nerve", 0.003)).toBe(Infinity);
});

test("a pulp is spared also where no exercise says so", () => {
  expect(usualGuards(scene({}))).toEqual([{tissue: "pulp", within_mm: 0.5}]);
});

test("its tip and its side are, from a box or a mesh, in whatever frames the two are", () => {
  const pose = at([0.01, -0.02, 0.03], aboutAxis([0.6, 0, 0.8], 1.1));
  const lying = multiply(pose.q, aboutAxis([0, 0, 1], Math.PI / 2));
  const boxed = {low: [-0.002, -0.002, -0.002], high: [0.002, 0.002, 0.002]};
  for (const region of [boxed, {mesh: meshOf(box(0.004))}]) {
    const model = scene(region, pose);
    const away = (p: Vec3, q: Quat): number =>
      guardedM(model, kCylinder, at(pointOf(pose, p), q), "pulp", 0.003);
    expect(away([0.0001, 0.0024, 0.0003], pose.q)).toBeCloseTo(0.0004, 6);
    expect(away([0.0019, 0.0031, 0], lying)).toBeCloseTo(0.0006, 5);
    // Beside an edge, the nearest of the tip's rim.
    expect(away([0.0028, 0.0024, 0], pose.q)).toBeCloseTo(Math.hypot(0.0004, 0.0005) - 0.0001, 5);
  }
});

test("a bur within a tissue touches none of its surface, and has opened it all the same", () => {
  const model = scene({mesh: meshOf(box(0.01))});
  expect(guardedM(model, kBall, at([0.0003, 0.0002, 0.0001]), "pulp", 0.003)).toBe(0);
});
