import type {Body} from "./bundle";
import {add, dot, norm, scale, subtract, type Vec3} from "../base/pose";

/// The shape of a tool from its working end on, as a few balls in a row: that of its shadow.

export interface NearEndBall {
  readonly centre: Vec3;
  readonly radiusM: number;
}

/// Each is the mean of the vertices that are nearer to the end [of the work area's radius].
const kWithin = [0.08, 0.25, 0.8, Infinity];
export const kNearEndBalls = kWithin.length;

/// Returns kNearEndBalls, no two at the same place.
/// @param end  in the tool's frame, as what is returned
export function nearEndOf({geometry: {vertices}}: Body, end: Vec3, sightM: number): NearEndBall[] {
  const groups = kWithin.map((): Vec3[] => []);
  for (let i = 0; i + 2 < vertices.length; i += 3) {
    const vertex: Vec3 = [vertices[i]!, vertices[i + 1]!, vertices[i + 2]!];
    const away = norm(subtract(vertex, end)) / sightM;
    groups[kWithin.findIndex((within) => away < within)]!.push(vertex);
  }
  const filled = groups.filter((group) => group.length > 0);
  const centres = filled.map((group) => scale(group.reduce(add), 1 / group.length));
  const balls = filled.map((group, i) => {
    const [before, after] = [centres[i - 1] ?? centres[i]!, centres[i + 1] ?? centres[i]!];
    const along = subtract(after, before);
    const axis = scale(along, 1 / Math.max(1e-12, norm(along)));
    const beside = group.map((vertex) => {
      const off = subtract(vertex, centres[i]!);
      return norm(subtract(off, scale(axis, dot(off, axis))));
    });
    return {
      centre: centres[i]!,
      radiusM: beside.reduce((sum, one) => sum + one, 0) / beside.length,
    };
  });
  while (balls.length < kNearEndBalls) {
    const {centre, radiusM} = balls.at(-1)!;
    balls.push({centre: add(centre, [0.001 * sightM, 0, 0]), radiusM});
  }
  return balls;
}
