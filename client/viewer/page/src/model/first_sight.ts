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
} from "./pose";

/// Where the eye is at first: from there one sees the work and the tools' near ends, and the tools
/// from their side.

interface Ball {
  readonly centre: Vec3;
  readonly radiusM: number;
}

/// From where one looks where the scene does not say: a little from the right and above.
const kUsualSight: Vec3 = [0.32, 0.3, 1];
/// A tool that is so many times as long as it is thick has a direction.
const kLong = 3;
/// It is not seen more along its length than so: of what lies at 35 degrees more than half shows.
const kLeastAngle = (35 * Math.PI) / 180;
/// Of a tool larger than the work by this factor
const kLarge = 1.3;
/// only so much from its near end on is looked at first, as a share of the work's radius: that tells where it
/// is and comes from, and a handle would make the rest small.
const kReach = 0.6;

/// What it is about: what the scene says, else all its objects.
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

/// Where a tool's end is that works, in its frame: what is nearest to the work at the start.
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

/// @param poses  of the tools, as in the model
export function firstSight(model: SceneModel, poses: readonly Pose[]): FirstSight {
  const work = workOf(model);
  const balls: Ball[] = [work];
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
  return {...enclose(balls), from};
}

/// The direction nearest to `from` that is far enough from the axis.  Both are unit.
function across(from: Vec3, axis: Vec3): Vec3 {
  const along = dot(from, axis);
  if (Math.acos(Math.min(1, Math.abs(along))) >= kLeastAngle) return from;
  const towards = along < 0 ? scale(axis, -1) : axis;
  let aside = subtract(from, scale(towards, Math.abs(along)));
  if (norm(aside) < 1e-3) {
    // Exactly along it: from above, or where that is along it, too, from the right.
    const up: Vec3 = Math.abs(axis[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0];
    aside = subtract(up, scale(axis, dot(up, axis)));
  }
  return add(
    scale(towards, Math.cos(kLeastAngle)),
    scale(normalised(aside), Math.sin(kLeastAngle)),
  );
}

/// The direction in which a body is long, unit, in its frame; none where it is about as thick: that of
/// the largest variance of its vertices, by power iteration.
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
  // Thick in two directions.
  return long > 0.5 * kLong * kLong * thick ? axis : undefined;
}

const normalised = (a: Vec3): Vec3 => scale(a, 1 / Math.max(1e-12, norm(a)));

function* verticesOf({geometry: {vertices}}: Body): Generator<Vec3> {
  for (let i = 0; i + 2 < vertices.length; i += 3) {
    yield [vertices[i]!, vertices[i + 1]!, vertices[i + 2]!];
  }
}

/// A ball that holds them all: from the middle of the most distant two it grows until it does
/// (Ritter, "An efficient bounding sphere", 1990), a twentieth larger than the smallest at most.
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
