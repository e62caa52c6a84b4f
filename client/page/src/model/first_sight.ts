import {Sphere, Vector3} from "three";

import type {Body, FirstSight, SceneModel} from "./bundle";
import {
  add,
  dot,
  norm,
  pointIn,
  pointOf,
  type Pose,
  rotate,
  scale,
  subtract,
  type Vec3,
} from "../base/pose";

/// The initial position of the camera: it shows the work area and the tools' near ends, and the
/// tools from their side.

export interface Ball {
  readonly centre: Vec3;
  readonly radiusM: number;
}

/// Direction of view if the scene has none: a little from the right and above.
const kUsualSight: Vec3 = [0.32, 0.3, 1];
/// A tool has a direction if it is this many times as long as it is thick.
const kLong = 3;
/// Least angle between view and tool axis: at 35 degrees more than half of the tool's length shows.
const kLeastAngle = (35 * Math.PI) / 180;
/// If a tool is larger than the work area by this factor,
const kLarge = 1.3;
/// only this much from its near end is shown at first, as a share of the work area's radius: enough
/// to see where it is and comes from, while a whole handle would make the rest small.
const kReach = 0.6;

/// If the work area is larger than a tool by this factor, only this much around the tool is shown.
const kSmall = 5;

/// Returns the work area: the scene's, or else the ball around all objects.
export function workOf(model: SceneModel): Ball {
  return (
    model.firstSight ??
    enclose(
      model.objects.map(({pose, geometry}) => ({
        centre: pointOf(pose, geometry.centre),
        radiusM: geometry.radiusM,
      })),
    )
  );
}

/// Returns the working end of a tool, in its frame: the point nearest to the work area
/// at the start.
export function endOf(tool: Body, work: Ball): Vec3 {
  const target = pointIn(tool.pose, work.centre);
  let end: Vec3 = tool.geometry.centre;
  let least = Infinity;
  for (const vertex of verticesOf(tool)) {
    const away = norm(subtract(vertex, target));
    if (away >= least) continue;
    least = away;
    end = vertex;
  }
  return end;
}

/// @param poses  of the tools, in the model's order
export function firstSight(model: SceneModel, poses: readonly Pose[]): FirstSight {
  const work = workOf(model);
  const balls: Ball[] = [nearTool(model, poses, work)];
  let from = normalised(model.firstSight?.from ?? kUsualSight);
  model.tools.forEach((tool, i) => {
    const pose = poses[i] ?? tool.pose;
    const end = endOf(tool, work);
    const isLarge = tool.geometry.radiusM > kLarge * work.radiusM;
    const reachM = isLarge ? kReach * work.radiusM : Infinity;
    const near = [...verticesOf(tool)].filter((vertex) => norm(subtract(vertex, end)) <= reachM);
    balls.push(...near.map((vertex) => ({centre: pointOf(pose, vertex), radiusM: 0})));
    const axis = axisOf(tool);
    if (axis) from = across(from, rotate(pose.q, axis));
  });
  const [tool] = model.tools;
  const end = tool && pointOf(poses[0] ?? tool.pose, endOf(tool, work));
  return {...enclose(balls), from, end};
}

/// Returns the work area, or the part of it beside a tool that would be too small to be seen in all.
function nearTool(model: SceneModel, poses: readonly Pose[], work: Ball): Ball {
  const [tool] = model.tools;
  if (!tool) return work;
  const at = pointOf(poses[0] ?? tool.pose, tool.geometry.centre);
  const radiusM = kSmall * tool.geometry.radiusM;
  const away = subtract(work.centre, at);
  if (radiusM >= work.radiusM) return work;
  const share = Math.min(1, (radiusM - tool.geometry.radiusM) / norm(away));
  return {centre: add(at, scale(away, share)), radiusM};
}

/// Returns the direction nearest to `from` that is far enough from the axis.  Both
/// are unit vectors.
function across(from: Vec3, axis: Vec3): Vec3 {
  const along = dot(from, axis);
  if (Math.acos(Math.min(1, Math.abs(along))) >= kLeastAngle) return from;
  const towards = along < 0 ? scale(axis, -1) : axis;
  let aside = subtract(from, scale(towards, Math.abs(along)));
  if (norm(aside) < 1e-3) {
    // `from` is along the axis: look from above, or from the right if the axis is vertical.
    const up: Vec3 = Math.abs(axis[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0];
    aside = subtract(up, scale(axis, dot(up, axis)));
  }
  return add(
    scale(towards, Math.cos(kLeastAngle)),
    scale(normalised(aside), Math.sin(kLeastAngle)),
  );
}

/// Returns the long axis of a body, a unit vector in its frame: the direction of largest variance
/// of its vertices, by power iteration.  Undefined if it is about as thick as long.
export function axisOf(body: Body): Vec3 | undefined {
  const vertices = [...verticesOf(body)];
  if (vertices.length === 0) return undefined;
  const mean = scale(vertices.reduce(add), 1 / vertices.length);
  const offsets = vertices.map((vertex) => subtract(vertex, mean));
  let axis: Vec3 = normalised([1, 0.9, 0.8]);
  for (let round = 0; round < 20; round++) {
    let sum: Vec3 = [0, 0, 0];
    for (const offset of offsets) sum = add(sum, scale(offset, dot(offset, axis)));
    if (norm(sum) === 0) return undefined;
    axis = normalised(sum);
  }
  let [long, thick] = [0, 0];
  for (const offset of offsets) {
    const along = dot(offset, axis);
    long += along * along;
    thick += Math.max(0, dot(offset, offset) - along * along);
  }
  // It is thick in two directions.
  return long > 0.5 * kLong * kLong * thick ? axis : undefined;
}

const normalised = (a: Vec3): Vec3 => scale(a, 1 / Math.max(1e-12, norm(a)));

function* verticesOf({geometry: {vertices}}: Body): Generator<Vec3> {
  for (let i = 0; i + 2 < vertices.length; i += 3) {
    yield [vertices[i]!, vertices[i + 1]!, vertices[i + 2]!];
  }
}

/// Returns a ball that encloses all of them: it begins with the two most distant and grows until it
/// contains the rest (Ritter, "An efficient bounding sphere", 1990).  It is at most a twentieth
/// larger than the smallest.
function enclose(balls: readonly Ball[]): Ball {
  const [first] = balls;
  if (!first) return {centre: [0, 0, 0], radiusM: 0.1};
  const furthest = (from: Vec3): Ball =>
    balls.reduce((best, ball) => (reach(ball, from) > reach(best, from) ? ball : best));
  const a = furthest(first.centre);
  const hull = sphereOf(a);
  for (const ball of [furthest(a.centre), ...balls]) hull.union(sphereOf(ball));
  return {centre: hull.center.toArray(), radiusM: hull.radius};
}

const reach = ({centre, radiusM}: Ball, from: Vec3): number =>
  norm(subtract(centre, from)) + radiusM;
const sphereOf = ({centre, radiusM}: Ball): Sphere => new Sphere(new Vector3(...centre), radiusM);
