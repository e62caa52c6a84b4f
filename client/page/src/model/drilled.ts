import type {Bur, SceneModel, Triangles} from "./bundle";
import {add, norm, pointIn, type Pose, rotate, subtract, type Vec3} from "../base/pose";

/// How deep a bur is in what it cuts.

/// Returns how far a ray goes within a closed mesh before it leaves it; 0: it begins outside.  In
/// plain numbers, since a tooth has tens of thousands of triangles.
/// @param along  unit
export function withinM({vertices, triangles}: Triangles, from: Vec3, along: Vec3): number {
  const [dx, dy, dz] = along;
  let nearest = Infinity;
  let leaves = false;
  for (let i = 0; i + 2 < triangles.length; i += 3) {
    // Möller and Trumbore, "Fast, minimum storage ray-triangle intersection", 1997.
    const [a, b, c] = [3 * triangles[i]!, 3 * triangles[i + 1]!, 3 * triangles[i + 2]!];
    const [ax, ay, az] = [vertices[a]!, vertices[a + 1]!, vertices[a + 2]!];
    const [bx, by, bz] = [vertices[b]! - ax, vertices[b + 1]! - ay, vertices[b + 2]! - az];
    const [cx, cy, cz] = [vertices[c]! - ax, vertices[c + 1]! - ay, vertices[c + 2]! - az];
    const [px, py, pz] = [dy * cz - dz * cy, dz * cx - dx * cz, dx * cy - dy * cx];
    const facing = bx * px + by * py + bz * pz;
    if (facing === 0) continue;
    const [tx, ty, tz] = [from[0] - ax, from[1] - ay, from[2] - az];
    const u = (tx * px + ty * py + tz * pz) / facing;
    if (u < 0 || u > 1) continue;
    const [qx, qy, qz] = [ty * bz - tz * by, tz * bx - tx * bz, tx * by - ty * bx];
    const v = (dx * qx + dy * qy + dz * qz) / facing;
    const t = (cx * qx + cy * qy + cz * qz) / facing;
    if (v < 0 || u + v > 1 || t < 0 || t >= nearest) continue;
    nearest = t;
    leaves = facing < 0; // through the back of a triangle
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
