import {expect, test} from "vitest";

import {makeSurface} from "@page/model/surface";

import {ball, box} from "../support/scene_bytes";

const surfaceOf = ({
  vertices,
  triangles,
}: {
  vertices: readonly number[];
  triangles: readonly number[];
}) => makeSurface(Float32Array.from(vertices), Uint32Array.from(triangles));

test("a box has flat faces and sharp edges: each corner three times", () => {
  const surface = surfaceOf(box(2));
  expect(surface.source.length).toBe(24);
  for (let i = 0; i < surface.normals.length; i += 3) {
    const normal = [...surface.normals.subarray(i, i + 3)].map(
      (value) => Math.round(Math.abs(value) * 1e5) / 1e5,
    );
    expect(normal.sort()).toEqual([0, 0, 1]);
    // Outwards: along the corner's own position.
    expect(
      surface.normals
        .subarray(i, i + 3)
        .reduce((sum, value, k) => sum + value * surface.positions[i + k]!, 0),
    ).toBeGreaterThan(0.9);
  }
});

test("a ball is smooth: no vertex is split, and normals point from its centre", () => {
  const mesh = ball(1, 24, 36);
  const surface = surfaceOf(mesh);
  expect(surface.source.length).toBe(mesh.vertices.length / 3);
  for (let i = 0; i < surface.normals.length; i += 3) {
    const along = [0, 1, 2].reduce(
      (sum, k) => sum + surface.normals[i + k]! * surface.positions[i + k]!,
      0,
    );
    expect(along).toBeGreaterThan(0.998);
  }
});

test("triangles keep their places and their vertices", () => {
  for (const mesh of [box(1), ball(1)]) {
    const surface = surfaceOf(mesh);
    mesh.triangles.forEach((vertex, corner) => {
      expect(surface.source[surface.index[corner]!]).toBe(vertex);
    });
  }
});

test("a triangle without area spoils nothing", () => {
  const surface = makeSurface(
    Float32Array.from([0, 0, 0, 1, 0, 0, 0, 1, 0]),
    Uint32Array.from([0, 1, 2, 0, 1, 1]),
  );
  expect([...surface.normals].every(Number.isFinite)).toBe(true);
});
