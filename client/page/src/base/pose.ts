import {Quaternion, Vector3} from "three";

/// Poses as in messages: metres, and unit quaternions with w first.  X_AB maps coordinates in frame
/// B to frame A.
export type Vec3 = readonly [number, number, number];
export type Quat = readonly [number, number, number, number];

export interface Pose {
  readonly p: Vec3; // [m]
  readonly q: Quat; // w x y z
}

export const kIdentity: Pose = {p: [0, 0, 0], q: [1, 0, 0, 0]};

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a: Vec3, s: number): Vec3 => [a[0] * s, a[1] * s, a[2] * s];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
export const norm = (a: Vec3): number => Math.hypot(a[0], a[1], a[2]);

// three.js does the rotations.
const turn = (q: Quat): Quaternion => new Quaternion(q[1], q[2], q[3], q[0]);
const toQuat = ({w, x, y, z}: Quaternion): Quat => [w, x, y, z];

export const multiply = (a: Quat, b: Quat): Quat => toQuat(turn(a).multiply(turn(b)));
export const normalised = (q: Quat): Quat => toQuat(turn(q).normalize());
export const rotate = (q: Quat, v: Vec3): Vec3 =>
  new Vector3(...v).applyQuaternion(turn(q)).toArray();

/// Maps a point from the pose's own frame to its parent frame; and back.
export const pointOf = (pose: Pose, point: Vec3): Vec3 => add(pose.p, rotate(pose.q, point));
export const pointIn = (pose: Pose, point: Vec3): Vec3 =>
  rotate(toQuat(turn(pose.q).conjugate()), subtract(point, pose.p));

/// Rotation by `angle` [rad] about a unit axis.
export const aboutAxis = (axis: Vec3, angle: number): Quat =>
  toQuat(new Quaternion().setFromAxisAngle(new Vector3(...axis), angle));

/// Angle of the rotation from a to b [rad], 0 to pi.
export const angleBetween = (a: Quat, b: Quat): number => turn(a).angleTo(turn(b));

export const mixVec3 = (a: Vec3, b: Vec3, t: number): Vec3 => [
  a[0] + (b[0] - a[0]) * t,
  a[1] + (b[1] - a[1]) * t,
  a[2] + (b[2] - a[2]) * t,
];

/// Interpolates, along the shorter rotation.
export const mixPose = (a: Pose, b: Pose, t: number): Pose => ({
  p: mixVec3(a.p, b.p, t),
  q: toQuat(turn(a.q).slerp(turn(b.q), t)),
});

export const samePose = (a: Pose, b: Pose): boolean =>
  a.p.every((value, i) => value === b.p[i]) && a.q.every((value, i) => value === b.q[i]);
