import {expect, test} from "vitest";

import {makeBlockSurface, makePatch} from "@page/model/block_surface";
import type {Vec3} from "@page/base/pose";
import {Remains} from "@page/model/remains";
import {Skin} from "@page/model/skin";
import {makeSurface} from "@page/model/surface";
import {toSolidBlock} from "@page/protocol/messages";

import {box} from "../support/scene_bytes";
import {kLattice, kPitBlock, pit, solidBlock, surfaceCode} from "../support/solid_blocks";

const cube = box(0.05);
const cubeSurface = makeSurface(Float32Array.from(cube.vertices), Uint32Array.from(cube.triangles));

function surfacesOf(blocks: ReadonlyMap<number, Uint8Array>) {
  const remains = new Remains();
  for (const [number, surface] of blocks)
    remains.cut(toSolidBlock(solidBlock("cube", number, number + 1, surface)));
  const solid = remains.solidOf(0)!;
  const skin = new Skin(cubeSurface, solid.lattice);
  return (number: number) => {
    const patch = makePatch(solid, number, solid.blocks.get(number)!);
    return {patch, surface: makeBlockSurface(solid, number, patch, skin)};
  };
}

/// A strip along z that rises towards the block's border in x, and one that falls from there [spacings].
const strip = (from: Vec3, to: Vec3): Uint8Array => {
  const [a, b] = [from, to];
  const vertices = [a, [a[0], a[1], 5], [b[0], b[1], 5], b] as const;
  const [first, second] = [
    [0, 1, 2],
    [0, 2, 3],
  ] as const;
  return surfaceCode(vertices, [first, second]);
};

test("normals at a border go by the triangles on both sides of it, and are the same in both blocks", () => {
  const surfaces = surfacesOf(
    new Map([
      [21, strip([6, 2, 1], [8 - 1 / 3, 2 + 1 / 3, 1])],
      [22, strip([-1 / 3, 2 + 1 / 3, 1], [1 + 1 / 3, 2, 1])],
      [23, strip([6, 6, 1], [7, 6.2, 1])], // meets none of them
    ]),
  );
  const normalsAt = (number: number, x: number): number[][] => {
    const {positions, normals} = surfaces(number).surface;
    return [...Array(positions.length / 3).keys()]
      .filter((v) => Math.abs(positions[3 * v]! - x) < 1e-6)
      .map((v) => [...normals.subarray(3 * v, 3 * v + 3)]);
  };
  // Between blocks 1 and 2 along x.
  const borderM = -0.0336 + 2 * 0.0168 - 0.0007;
  const [left, right] = [normalsAt(21, borderM), normalsAt(22, borderM)];
  expect(left.length).toBe(2);
  for (const [x, y, z] of [...left, ...right]) {
    expect(x).toBeCloseTo(0, 2);
    expect(y).toBeCloseTo(1, 2);
    expect(z).toBeCloseTo(0, 2);
  }
  const away = normalsAt(21, -0.0336 + 0.0168 + 6 * 0.0021);
  expect(away[0]![0]).toBeCloseTo(-Math.sin(Math.atan(0.2)), 2);
});

test("a neighbour's news change a patch only where it meets the block", () => {
  const left = strip([6, 2, 1], [8 - 1 / 3, 2 + 1 / 3, 1]);
  const besideOf = (right: Uint8Array): number =>
    surfacesOf(
      new Map([
        [21, left],
        [22, right],
      ]),
    )(21).patch.beside;
  const alone = surfacesOf(new Map([[21, left]]))(21).patch.beside;
  const met = besideOf(strip([-1 / 3, 2 + 1 / 3, 1], [1 + 1 / 3, 2, 1]));
  expect(met).not.toBe(alone);
  expect(besideOf(strip([-1 / 3, 2 + 1 / 3, 1], [1 + 1 / 3, 2.5, 1]))).not.toBe(met);
  expect(besideOf(strip([3, 2 + 1 / 3, 1], [4, 2, 1]))).toBe(alone);
});

test("what is left of the mesh is known, and what is cut meets it at an edge however shallow", () => {
  for (const depthM of [0.007, 0.001]) {
    const {surface} = surfacesOf(new Map([[kPitBlock, pit(depthM)]]))(kPitBlock);
    const {positions, normals, index, onMesh} = surface;
    index.forEach((vertex, corner) => {
      const isTop = corner < 3 * 8;
      expect(onMesh[vertex]! >= 0, `corner ${corner}`).toBe(isTop);
      if (!isTop) return;
      expect(positions[3 * vertex + 1]).toBeCloseTo(0.025, 5);
      expect(normals[3 * vertex + 1]).toBeCloseTo(1, 5);
      // It is one of the top's two triangles.
      const top = [0, 1, 2].map((k) => cubeSurface.index[3 * onMesh[vertex]! + k]!);
      for (const of of top) expect(cubeSurface.positions[3 * of + 1]).toBeCloseTo(0.025, 6);
    });
  }
});

test("a place on the mesh is a mean of its triangle's corners", () => {
  const skin = new Skin(cubeSurface, {
    origin: [-0.0336, -0.0336, -0.0336],
    spacingM: kLattice.spacing_m,
    blocks: [4, 4, 4],
  });
  const p: Vec3 = [-0.01, 0.025, 0.004];
  const t = skin.at(kPitBlock, ...p, 0, 1, 0);
  const shares = skin.sharesOf(t, ...p);
  expect(shares.reduce((a, b) => a + b)).toBeCloseTo(1, 6);
  for (let axis = 0; axis < 3; axis++) {
    const mean = [0, 1, 2].reduce(
      (sum, k) =>
        sum + shares[k]! * cubeSurface.positions[3 * cubeSurface.index[3 * t + k]! + axis]!,
      0,
    );
    expect(mean).toBeCloseTo(p[axis]!, 6);
  }
  expect(skin.at(kPitBlock, ...p, 1, 0, 0)).toBe(-1); // faces elsewhere
  expect(skin.isAt(kPitBlock, p[0], p[1] - 0.0005, p[2])).toBe(false);
});
