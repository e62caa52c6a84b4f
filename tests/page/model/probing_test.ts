import {expect, test} from "vitest";

import type {SceneModel} from "@page/model/bundle";
import {aboutAxis, kIdentity, type Pose, rotate, type Vec3} from "@page/base/pose";
import {probingDepthM, tellsProbingDepth} from "@page/model/probing";

/// A margin at a height that is a circle of 5 mm seen from above; by the angle it may rise.
const circle = (height: (angle: number) => number): Vec3[] =>
  Array.from({length: 96}, (_, i) => {
    const angle = (2 * Math.PI * i) / 96;
    return [5e-3 * Math.sin(angle), height(angle), 5e-3 * Math.cos(angle)];
  });

const gum = (margin: readonly Vec3[], look = "probe", pose: Pose = kIdentity): SceneModel =>
  ({
    tools: [{name: "probe", look}],
    objects: [
      {margin: [], pose: kIdentity},
      {margin, pose},
    ],
  }) as unknown as SceneModel;

const kFlat = gum(circle(() => 1e-3));
const upright = (p: Vec3): Pose => ({p, q: [1, 0, 0, 0]});

test("the depth is from the margin to the tip, along the probe", () => {
  expect(probingDepthM(kFlat, upright([0, -4.9e-3, 4.5e-3]))).toBeCloseTo(5.9e-3, 9);
  // Tilted by 60 degrees about the point where it passes the margin, as far in: its marks say the same.
  const q = aboutAxis([1, 0, 0], Math.PI / 3);
  const [x, y, z] = rotate(q, [0, 1, 0]);
  const tip: Vec3 = [-3e-3 * x, 1e-3 - 3e-3 * y, 5e-3 - 3e-3 * z];
  expect(probingDepthM(kFlat, {p: tip, q})).toBeCloseTo(3e-3, 9);
});

test("it is the margin where the probe is that counts", () => {
  const rising = gum(circle((angle) => 1e-3 + 1e-3 * Math.sin(angle)));
  expect(probingDepthM(rising, upright([4.5e-3, -1e-3, 0]))).toBeCloseTo(3e-3, 5);
  expect(probingDepthM(rising, upright([-4.5e-3, -1e-3, 0]))).toBeCloseTo(1e-3, 5);
});

test("above the margin, and outside of it, there is no depth", () => {
  expect(probingDepthM(kFlat, upright([0, 2e-3, 4.5e-3]))).toBe(0);
  expect(probingDepthM(kFlat, upright([0, -4e-3, 5.2e-3]))).toBe(0);
});

test("it goes with the gum, wherever that stands", () => {
  const pose: Pose = {p: [0.1, 0.2, 0.3], q: aboutAxis([0, 0, 1], Math.PI)};
  const tip: Vec3 = [0.1, 0.2 + 4e-3, 0.3 + 4.5e-3];
  const model = gum(
    circle(() => 1e-3),
    "probe",
    pose,
  );
  expect(probingDepthM(model, {p: tip, q: pose.q})).toBeCloseTo(5e-3, 9);
});

test("of what is no probe, or where no margin is known, nothing is told", () => {
  expect(tellsProbingDepth(kFlat, "probe")).toBe(true);
  expect(tellsProbingDepth(kFlat, "scaler")).toBe(false);
  expect(
    tellsProbingDepth(
      gum(
        circle(() => 0),
        "steel",
      ),
      "probe",
    ),
  ).toBe(false);
  expect(tellsProbingDepth(gum([]), "probe")).toBe(false);
});
