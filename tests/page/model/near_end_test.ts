import {expect, test} from "vitest";

import type {Body} from "@page/model/bundle";
import {kNearEndBalls, nearEndOf} from "@page/model/near_end";
import {norm, subtract, type Vec3} from "@page/base/pose";

import {ball} from "../support/scene_bytes";

const bodyOf = (vertices: readonly number[]): Body =>
  ({geometry: {vertices: Float32Array.from(vertices)}}) as unknown as Body;
/// Rings round y, each of a height and a radius.
const turned = (rings: readonly (readonly [y: number, radius: number])[]): number[] =>
  rings.flatMap(([y, radius]) =>
    Array.from({length: 24}, (_, i) => (Math.PI * i) / 12).flatMap((angle) => [
      radius * Math.cos(angle),
      y,
      radius * Math.sin(angle),
    ]),
  );

test("a long tool is a row of balls from its end on, as thick as it is", () => {
  const bur = bodyOf(
    turned([
      [0, 1e-5],
      [0.0005, 0.0005],
      [0.001, 0.0007],
      [0.003, 0.0004],
      [0.02, 0.001],
    ]),
  );
  const row = nearEndOf(bur, [0, 0, 0], 0.0075);
  expect(row).toHaveLength(kNearEndBalls);
  for (const {centre} of row.slice(0, 4)) {
    expect(Math.hypot(centre[0], centre[2])).toBeLessThan(1e-5);
  }
  const last = row.at(-1)!;
  expect(last.centre[1]).toBeCloseTo(0.02, 4);
  expect(last.radiusM).toBeCloseTo(0.001, 5);
  row.slice(1).forEach(({centre}, i) => expect(centre[1]).toBeGreaterThan(row[i]!.centre[1]));
});

test("a small tool has as many, no two at the same place", () => {
  const centre: Vec3 = [0, 0, 0];
  const row = nearEndOf(bodyOf(ball(0.001).vertices), centre, 0.1);
  expect(row).toHaveLength(kNearEndBalls);
  row.slice(1).forEach((one, i) => {
    expect(norm(subtract(one.centre, row[i]!.centre))).toBeGreaterThan(0);
    expect(one.radiusM).toBeGreaterThan(0.0005);
  });
});
