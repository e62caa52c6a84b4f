import type {SceneModel} from "./bundle";
import {
  add,
  cross,
  dot,
  norm,
  pointOf,
  type Pose,
  rotate,
  scale,
  subtract,
  type Vec3,
} from "../base/pose";

/// The depth of a probe's tip below the gingival margin, as its own marks show it: along the probe,
/// whose tip is at its origin and points to -y (the look "probe", scenes/catalogue/README.md).

/// 25 g, the force of periodontal probing [N].
export const kProbeLimitN = 0.245;

export const isProbe = (model: SceneModel, tool: string): boolean =>
  model.tools.some(({name, look}) => name === tool && look === "probe");

/// Returns whether a tool has a probing depth: it is a probe, and a gum's margin is known.
export const tellsProbingDepth = (model: SceneModel, tool: string): boolean =>
  isProbe(model, tool) && model.objects.some(({margin}) => margin.length >= 3);

/// Returns 0 if the tip is below no margin.   @param graphic  pose of the probe
export function probingDepthM(model: SceneModel, graphic: Pose): number {
  const along = rotate(graphic.q, [0, 1, 0]);
  let depth = 0;
  for (const {margin, pose} of model.objects) {
    if (margin.length < 3) continue;
    const curve = margin.map((point) => pointOf(pose, point));
    // A tip outside the margin only leans on the gum's outer side.
    if (isInside(curve, graphic.p)) depth = Math.max(depth, depthBelow(curve, graphic.p, along));
  }
  return depth;
}

/// Distance from the tip to the point of the probe nearest to the curve.
function depthBelow(curve: readonly Vec3[], tip: Vec3, along: Vec3): number {
  let least = Infinity;
  let depth = 0;
  curve.forEach((point, i) => {
    const next = curve[(i + 1) % curve.length]!;
    // The point of this piece nearest to the probe's line, as seen along that line.
    const a = sideways(subtract(point, tip), along);
    const b = subtract(sideways(subtract(next, tip), along), a);
    const t = Math.min(1, Math.max(0, -dot(a, b) / Math.max(1e-18, dot(b, b))));
    const away = norm(add(a, scale(b, t)));
    if (away >= least) return;
    least = away;
    depth = dot(subtract(add(point, scale(subtract(next, point), t)), tip), along);
  });
  return depth;
}

const sideways = (a: Vec3, along: Vec3): Vec3 => subtract(a, scale(along, dot(a, along)));

/// Seen along the curve's axis, a point is inside if the angles subtended by the curve's pieces add
/// up to a full turn.
function isInside(curve: readonly Vec3[], point: Vec3): boolean {
  const offsets = curve.map((corner) => subtract(corner, point));
  let normal: Vec3 = [0, 0, 0];
  offsets.forEach((a, i) => (normal = add(normal, cross(a, offsets[(i + 1) % offsets.length]!))));
  normal = scale(normal, 1 / Math.max(1e-18, norm(normal)));
  const flat = offsets.map((offset) => sideways(offset, normal));
  let turn = 0;
  flat.forEach((a, i) => {
    const b = flat[(i + 1) % flat.length]!;
    turn += Math.atan2(dot(normal, cross(a, b)), dot(a, b));
  });
  return Math.abs(turn) > Math.PI;
}
