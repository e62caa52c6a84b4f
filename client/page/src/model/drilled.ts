import {Ray, Vector3} from "three";

import type {Bur, SceneModel, Triangles} from "./bundle";
import {add, norm, pointIn, type Pose, rotate, subtract, type Vec3} from "../base/pose";

/// How deep a bur is in what it cuts.

const [kA, kB, kC, kHit] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];

/// Returns how far a ray goes within a closed mesh before it leaves it; 0: it begins outside.
/// @param along  unit
export function withinM({vertices, triangles}: Triangles, from: Vec3, along: Vec3): number {
  const ray = new Ray(new Vector3(...from), new Vector3(...along));
  let nearest = Infinity;
  let leaves = false;
  for (let i = 0; i + 2 < triangles.length; i += 3) {
    [kA, kB, kC].forEach((corner, k) => corner.fromArray(vertices, 3 * triangles[i + k]!));
    if (!ray.intersectTriangle(kA, kB, kC, false, kHit)) continue;
    const away = kHit.distanceTo(ray.origin);
    if (away >= nearest) continue;
    nearest = away;
    leaves = kB.sub(kA).cross(kC.sub(kA)).dot(ray.direction) > 0; // through the back of a triangle
  }
  return leaves ? nearest : 0;
}

/// The bur of a tool; undefined: it is none.
export const burOf = (model: SceneModel | undefined, tool: string): Bur | undefined =>
  model?.tools.find(({name}) => name === tool)?.bur;

/// Returns how deep a bur's tip is below the original surface of what burs cut, along the bur.
/// @param graphic  pose of the bur, whose tip is at its origin and which points to -y
export function drilledM(model: SceneModel, graphic: Pose): number {
  const end = add(graphic.p, rotate(graphic.q, [0, 1, 0]));
  return Math.max(
    0,
    ...model.objects
      .filter(({cutColours}) => cutColours.length > 0)
      .map(({pose, geometry}) => {
        const tip = pointIn(pose, graphic.p);
        if (norm(subtract(tip, geometry.centre)) > geometry.radiusM) return 0;
        return withinM(geometry, tip, subtract(pointIn(pose, end), tip));
      }),
  );
}
