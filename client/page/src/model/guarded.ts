import {BoxGeometry} from "three";

import type {Bur, Region, SceneModel, Triangles} from "./bundle";
import {withinM} from "./drilled";
import type {Guard} from "../protocol/exercise_messages";
import {
  add,
  mixVec3,
  norm,
  pointIn,
  pointOf,
  type Pose,
  rotate,
  scale,
  subtract,
  type Vec3,
} from "../base/pose";

/// The distance from a bur's surface to a tissue that an exercise guards, such as the pulp: between
/// the bur's own profile, where the server has the bur, and the scene's regions of that tissue, as
/// a score takes them (client/replayer/score/cut_measures.h).

/// The tissue's surface is taken at points no farther apart than this [m]: the distance is at most
/// 0.01 mm too large.
const kApartM = 0.2e-3;

/// What every bur is to spare, where no exercise says so.
const kSpared: readonly string[] = ["pulp", "nerve"];
const kWarnMm = 0.5;

/// What a scene has of that.
export const usualGuards = ({objects}: SceneModel): readonly Guard[] =>
  kSpared
    .filter((tissue) => objects.some(({tissues}) => tissues.includes(tissue)))
    .map((tissue) => ({tissue, within_mm: kWarnMm}));

interface Cloud {
  readonly points: readonly Vec3[];
  readonly radiusM: number; // of the ball that each is
  readonly mesh: Triangles | undefined;
  readonly centre: Vec3;
  readonly reachM: number; // from there
}

const kClouds = new WeakMap<Region, Cloud>();

function cloudOf(region: Region): Cloud {
  let cloud = kClouds.get(region);
  if (!cloud) kClouds.set(region, (cloud = makeCloud(region)));
  return cloud;
}

function makeCloud({low, high, radiusM, mesh}: Region): Cloud {
  if (radiusM > 0) return {points: [low], radiusM, mesh: undefined, centre: low, reachM: radiusM};
  const solid = mesh ?? boxOf(low, high);
  const points: Vec3[] = [];
  for (let i = 0; i + 2 < solid.triangles.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k): Vec3 => {
      const at = 3 * solid.triangles[i + k]!;
      return [solid.vertices[at]!, solid.vertices[at + 1]!, solid.vertices[at + 2]!];
    }) as [Vec3, Vec3, Vec3];
    const longest = Math.max(norm(subtract(a, b)), norm(subtract(b, c)), norm(subtract(c, a)));
    const n = Math.max(1, Math.ceil(longest / kApartM));
    for (let u = 0; u <= n; u++) {
      const [from, to] = [mixVec3(a, b, u / n), mixVec3(a, c, u / n)];
      for (let v = 0; v <= u; v++) points.push(u === 0 ? a : mixVec3(from, to, v / u));
    }
  }
  const centre = scale(points.reduce(add), 1 / points.length);
  const reachM = points.reduce((most, point) => Math.max(most, norm(subtract(point, centre))), 0);
  return {points, radiusM: 0, mesh: solid, centre, reachM};
}

function boxOf(low: Vec3, high: Vec3): Triangles {
  const middle = scale(add(low, high), 0.5);
  const box = new BoxGeometry(...subtract(high, low)).translate(...middle);
  const vertices = box.getAttribute("position").array as Float32Array;
  return {vertices, triangles: Uint32Array.from(box.index!.array)};
}

/// Distance of a point of the bur's frame from it; 0: within it.
function outsideM({curve, rounding}: Bur, x: number, y: number, z: number): number {
  const rho = Math.hypot(x, z);
  let least = Infinity;
  let within = false;
  curve.forEach(([rhoA, yA], i) => {
    const [rhoB, yB] = curve[(i + 1) % curve.length]!;
    const [toRho, toY] = [rhoB - rhoA, yB - yA];
    const along = ((rho - rhoA) * toRho + (y - yA) * toY) / (toRho * toRho + toY * toY || 1);
    const t = Math.min(1, Math.max(0, along));
    least = Math.min(least, Math.hypot(rho - rhoA - t * toRho, y - yA - t * toY));
    if (yA > y !== yB > y && rho < rhoA + ((y - yA) / (yB - yA)) * toRho) within = !within;
  });
  return within ? 0 : Math.max(0, least - rounding);
}

/// @param graphic  pose of the bur
/// @param mostM    nobody asks about more
/// @return 0: it is opened; Infinity: it is farther away, or the scene has no such tissue
export function guardedM(
  {objects}: SceneModel,
  bur: Bur,
  graphic: Pose,
  tissue: string,
  mostM: number,
): number {
  let least = Infinity;
  const burReachM = Math.max(...bur.curve.map(([rho, y]) => Math.hypot(rho, y))) + bur.rounding;
  for (const {pose, regions, tissues} of objects) {
    const inTool = (point: Vec3): Vec3 => pointIn(graphic, pointOf(pose, point));
    const origin = inTool([0, 0, 0]);
    const [ex, ey, ez] = [
      subtract(inTool([1, 0, 0]), origin),
      subtract(inTool([0, 1, 0]), origin),
      subtract(inTool([0, 0, 1]), origin),
    ];
    for (const region of regions) {
      if (tissues[region.tissue] !== tissue) continue;
      const {points, radiusM, mesh, centre, reachM} = cloudOf(region);
      if (norm(inTool(centre)) > reachM + burReachM + mostM) continue;
      const middle = pointIn(pose, add(graphic.p, rotate(graphic.q, [0, bur.curve[0]![1], 0])));
      if (mesh && withinM(mesh, middle, [0, 1, 0]) > 0) return 0;
      for (const [px, py, pz] of points) {
        const away = outsideM(
          bur,
          origin[0] + px * ex[0] + py * ey[0] + pz * ez[0],
          origin[1] + px * ex[1] + py * ey[1] + pz * ez[1],
          origin[2] + px * ex[2] + py * ey[2] + pz * ez[2],
        );
        least = Math.min(least, Math.max(0, away - radiusM));
      }
    }
  }
  return least <= mostM ? least : Infinity;
}
