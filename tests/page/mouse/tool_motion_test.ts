import {expect, test} from "vitest";

import {add, norm, type Pose, rotate, subtract, type Vec3} from "@page/base/pose";
import {leash, push, roll, slide, turn, type ViewFrame} from "@page/mouse/tool_motion";

/// An eye on +z that looks at the origin: 1 mm a pixel.
const kView: ViewFrame = {
  right: [1, 0, 0],
  up: [0, 1, 0],
  forward: [0, 0, -1],
  metresPerPixel: 0.001,
};
const kPose: Pose = {p: [0.1, 0.2, 0.3], q: [1, 0, 0, 0]};
const kCentroid: Vec3 = [0.01, -0.02, 0.03];
const centre = (pose: Pose): Vec3 => add(pose.p, rotate(pose.q, kCentroid));

const near = (a: Vec3, b: Vec3): void => expect(norm(subtract(a, b))).toBeLessThan(1e-12);

test("a drag moves the tool with the pointer, in the plane of the picture", () => {
  near(slide(kPose, kView, 10, 0).p, [0.11, 0.2, 0.3]);
  near(slide(kPose, kView, 0, 10).p, [0.1, 0.19, 0.3]); // down on the screen is down
});

test("a push goes away from the eye", () => {
  near(push(kPose, kView, 0.02).p, [0.1, 0.2, 0.28]);
});

test("turning leaves the tool's centroid where it is", () => {
  near(centre(turn(kPose, kView, kCentroid, 40, -25)), centre(kPose));
  near(centre(roll(kPose, kView, kCentroid, 0.7)), centre(kPose));
});

test("the side of the tool that faces the eye follows the pointer", () => {
  const front: Vec3 = [0, 0, 1];
  expect(rotate(turn(kPose, kView, kCentroid, 30, 0).q, front)[0]).toBeGreaterThan(0.1);
  expect(rotate(turn(kPose, kView, kCentroid, 0, 30).q, front)[1]).toBeLessThan(-0.1);
});

test("a roll goes clockwise as seen", () => {
  expect(rotate(roll(kPose, kView, kCentroid, Math.PI / 2).q, [0, 1, 0])[0]).toBeCloseTo(1, 9);
});

test("the leash holds what is far and leaves what is near", () => {
  const graphic: Pose = {p: [0.1, 0.2, 0], q: [1, 0, 0, 0]};
  near(leash(kPose, graphic, 0.02).p, [0.1, 0.2, 0.02]);
  expect(leash(kPose, graphic, 1)).toBe(kPose);
});
