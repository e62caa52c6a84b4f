import {
  aboutAxis,
  add,
  multiply,
  norm,
  normalised,
  pointOf,
  type Pose,
  rotate,
  scale,
  subtract,
  type Vec3,
} from "../base/pose";

/// How a drag on the screen moves the haptic tool: in the picture's plane, along the view, or about
/// the tool's centroid.  Screen pixels: x to the right, y down.
export interface ViewFrame {
  readonly right: Vec3; // unit, in W
  readonly up: Vec3;
  readonly forward: Vec3; // away from the camera
  readonly metresPerPixel: number; // at the tool
}

const kRadiansPerPixel = 0.008;

export function slide(pose: Pose, view: ViewFrame, dx: number, dy: number): Pose {
  const move = add(
    scale(view.right, dx * view.metresPerPixel),
    scale(view.up, -dy * view.metresPerPixel),
  );
  return {p: add(pose.p, move), q: pose.q};
}

export const push = (pose: Pose, view: ViewFrame, metres: number): Pose => ({
  p: add(pose.p, scale(view.forward, metres)),
  q: pose.q,
});

/// Rotates so that the tool's front follows the pointer.  @param centroid  in the tool's frame
export function turn(pose: Pose, view: ViewFrame, centroid: Vec3, dx: number, dy: number): Pose {
  const yaw = aboutAxis(view.up, dx * kRadiansPerPixel);
  const pitch = aboutAxis(view.right, dy * kRadiansPerPixel);
  return turnBy(pose, centroid, multiply(yaw, pitch));
}

/// Rotates about the line of sight, clockwise as seen.
export const roll = (pose: Pose, view: ViewFrame, centroid: Vec3, radians: number): Pose =>
  turnBy(pose, centroid, aboutAxis(view.forward, radians));

function turnBy(pose: Pose, centroid: Vec3, by: readonly [number, number, number, number]): Pose {
  const q = normalised(multiply(by, pose.q));
  const centre = pointOf(pose, centroid);
  return {p: subtract(centre, rotate(q, centroid)), q};
}

/// Returns the nearest pose at most `reachM` from the graphic tool: no force stops a pointer, which
/// would otherwise pull as hard as the screen is wide.
export function leash(pose: Pose, graphic: Pose, reachM: number): Pose {
  const away = subtract(pose.p, graphic.p);
  const distance = norm(away);
  if (distance <= reachM) return pose;
  return {p: add(graphic.p, scale(away, reachM / distance)), q: pose.q};
}
