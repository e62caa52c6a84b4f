import {expect, test} from "vitest";

import type {SceneModel} from "@page/model/bundle";
import {aboutAxis, kIdentity, type Pose, rotate, scale} from "@page/base/pose";
import {drilledM} from "@page/model/drilled";

import {ball, box} from "../support/scene_bytes";

const sceneOf = (mesh: ReturnType<typeof box>, pose: Pose = kIdentity): SceneModel => {
  const geometry = {
    vertices: Float32Array.from(mesh.vertices),
    triangles: Uint32Array.from(mesh.triangles),
    centre: [0, 0, 0],
    radiusM: 0.02,
  };
  return {objects: [{pose, geometry, cutColours: [0]}]} as unknown as SceneModel;
};

test("the depth is from the original surface to the tip, along the bur", () => {
  const scene = sceneOf(box(0.02));
  const at = (x: number, y: number, q = kIdentity.q): Pose => ({p: [x, y, 0.001], q});
  expect(drilledM(scene, at(0.002, 0.007))).toBeCloseTo(0.003, 9);
  expect(drilledM(scene, at(0.002, 0.0101))).toBe(0);
  expect(drilledM(scene, at(0.05, 0.007))).toBe(0);
  // Upside down it points out of the bottom.
  expect(drilledM(scene, at(0.002, -0.0101, aboutAxis([1, 0, 0], Math.PI)))).toBe(0);
  const tilted = aboutAxis([0, 0, 1], Math.PI / 3);
  expect(drilledM(scene, at(0, 0.007, tilted))).toBeCloseTo(0.006, 9);
});

test("it is that of an object where it is, whatever it is made of", () => {
  const q = aboutAxis([0.6, 0.8, 0], 0.7);
  const pose: Pose = {p: [0.1, 0.2, 0.3], q};
  const along = rotate(aboutAxis([0, 0, 1], 0.4), [0, 1, 0]);
  const tip: Pose = {p: pose.p, q: aboutAxis([0, 0, 1], 0.4)};
  expect(drilledM(sceneOf(ball(0.01, 64, 96), pose), tip)).toBeCloseTo(0.01, 4);
  const out = scale(along, 0.02).map((x, i) => x + pose.p[i]!) as unknown as Pose["p"];
  expect(drilledM(sceneOf(ball(0.01, 64, 96), pose), {...tip, p: out})).toBe(0);
});
