import {expect, test} from "vitest";

import {makeSurface} from "@page/model/surface";
import {coarsen} from "@page/view/coarsen";

import {ball, box} from "../support/scene_bytes";

test("coarser triangles are fewer, and as near to the surface as was asked for", async () => {
  const radius = 0.05;
  const {vertices, triangles} = ball(radius, 64, 96);
  const surface = makeSurface(Float32Array.from(vertices), Uint32Array.from(triangles));
  const distances = [0.0002, 0.001];
  const indices = await coarsen(surface, distances);
  expect(indices.length).toBe(2);
  let before = surface.index.length;
  indices.forEach((index, detail) => {
    expect(index.count).toBeGreaterThan(12);
    expect(index.count).toBeLessThan(before / 2);
    before = index.count;
    for (let i = 0; i < index.count; i += 3) {
      // A flat triangle is furthest from a ball at its middle.
      const corners = [0, 1, 2].map((k) => index.getX(i + k));
      const middle = [0, 1, 2].map(
        (axis) => corners.reduce((sum, v) => sum + surface.positions[3 * v + axis]!, 0) / 3,
      );
      expect(Math.abs(Math.hypot(...middle) - radius)).toBeLessThan(2 * distances[detail]!);
    }
  });
});

test("edges stay where they are", async () => {
  const {vertices, triangles} = box(0.05);
  const surface = makeSurface(Float32Array.from(vertices), Uint32Array.from(triangles));
  const [index] = await coarsen(surface, [0.001]);
  expect(index!.count).toBe(36);
});
