import type {ContactPoint, ToolState} from "../protocol/messages";
import type {Body, SceneModel} from "./bundle";
import {add, norm, pointIn, type Pose, scale, subtract, type Vec3} from "../base/pose";

/// Largest distance of a contact from the object touched: soft surfaces give way [m].
const kReachM = 3e-3;
const kLeastN = 0.01;

/// Returns the names of the objects that push the tool, the strongest first.
export function touchedObjects(
  model: SceneModel,
  {points, moved}: Pick<ToolState, "points" | "moved">,
): string[] {
  const newtons = new Map<string, number>();
  for (const {positionM, forceN} of points) {
    const force = norm(forceN);
    if (force < kLeastN) continue;
    const body = nearest(model.objects, moved, positionM);
    if (body) newtons.set(body.name, (newtons.get(body.name) ?? 0) + force);
  }
  return [...newtons].sort(([, a], [, b]) => b - a).map(([name]) => name);
}

function nearest(objects: readonly Body[], moved: readonly Pose[], at: Vec3): Body | undefined {
  // Measured to vertices, which is quick; where objects meet, their meshes are fine.
  let found: Body | undefined;
  let least = Infinity;
  for (const body of objects) {
    const group = moved[body.moved - 1];
    const local = pointIn(body.pose, group ? pointIn(group, at) : at);
    const {centre, radiusM, vertices} = body.geometry;
    if (norm(subtract(local, centre)) > radiusM + kReachM) continue;
    for (let i = 0; i < vertices.length; i += 3) {
      const dx = vertices[i]! - local[0];
      const dy = vertices[i + 1]! - local[1];
      const dz = vertices[i + 2]! - local[2];
      const square = dx * dx + dy * dy + dz * dz;
      if (square < least) {
        least = square;
        found = body;
      }
    }
  }
  return found;
}

/// Returns the force-weighted mean of the contact points; undefined if nothing pushes.
export function middleOfPush(points: readonly ContactPoint[]): Vec3 | undefined {
  let sum: Vec3 = [0, 0, 0];
  let newtons = 0;
  for (const {positionM, forceN} of points) {
    const force = norm(forceN);
    sum = add(sum, scale(positionM, force));
    newtons += force;
  }
  return newtons < kLeastN ? undefined : scale(sum, 1 / newtons);
}
