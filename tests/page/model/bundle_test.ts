import {expect, test} from "vitest";

import {readBundle} from "@page/model/bundle";

import {ball, box, kMarked, kTestScene, sceneBytes} from "../support/scene_bytes";

test("a bundle's bodies are read as they were written", () => {
  const scene = readBundle(sceneBytes(kTestScene));
  expect(scene.name).toBe("test-box");
  expect(scene.tools.map(({name}) => name)).toEqual(["ball"]);
  expect(scene.tools[0]!.pose).toEqual({p: [0, 0.06, 0], q: [1, 0, 0, 0]});
  const geometry = scene.objects[0]!.geometry;
  expect([...geometry.triangles]).toEqual(box(0.05).triangles);
  expect([...geometry.vertices]).toEqual([...Float32Array.from(box(0.05).vertices)]);
  expect(geometry.radiusM).toBeCloseTo(0.025 * Math.sqrt(3), 7);
  expect(geometry.levels.map(({radii}) => radii.length)).toEqual([8, 12]);
  expect(scene.objects[0]!.materials[0]!.stiffness).toBe(Infinity);
  expect(scene.isCut).toBe(false);
});

test("what burs cut is known, and what that takes", () => {
  const scene = readBundle(sceneBytes(kMarked));
  expect(scene.isCut).toBe(true);
  const {cutColours, tissues, regions} = scene.objects[0]!;
  expect(cutColours).toEqual([0x1000000, 0x5a3a20]);
  expect(tissues).toEqual(["shell", "core"]);
  expect(regions).toMatchObject([{low: [0, 0.02, 0], radiusM: 0.01, tissue: 1}]);
});

test("the header of a bundle file is passed over, wherever the bytes lie", () => {
  const content = sceneBytes(kTestScene);
  for (const shift of [0, 1, 3]) {
    const file = new Uint8Array(shift + 40 + content.length).subarray(shift);
    file.set(new TextEncoder().encode("PALP\r\n\x1a\n"));
    file.set(content, 40);
    expect(readBundle(file).objects[0]!.geometry.triangles.length).toBe(36);
  }
});

test("lanes without a node are no spheres", () => {
  const mesh = ball(0.01);
  const leaves = [0, 1, 2].map(() => ({centre: [0, 0, 0] as const, radius: 0.01, triangles: []}));
  const scene = readBundle(
    sceneBytes({name: "three", tools: [], objects: [{name: "ball", mesh, leaves}]}),
  );
  expect(scene.objects[0]!.geometry.levels.map(({radii}) => radii.length)).toEqual([3, 3]);
});

test("bytes that are no scene are refused", () => {
  expect(() => readBundle(new Uint8Array(100))).toThrow(/no scene/);
  expect(() => readBundle(new Uint8Array())).toThrow(/no scene/);
});
