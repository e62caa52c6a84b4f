import {expect, test} from "vitest";

import type {Body, SceneModel} from "@page/model/bundle";
import type {Pose, Vec3} from "@page/base/pose";
import type {ContactPoint} from "@page/protocol/messages";
import {middleOfPush, touchedObjects} from "@page/model/touched";
import {touchedWords} from "@page/model/words";

/// A square of side 2 mm across y, at that height.
const plate = (name: string, y: number, q: Body["pose"]["q"] = [1, 0, 0, 0]): Body =>
  ({
    name,
    moved: 0,
    pose: {p: [0, y, 0], q},
    geometry: {
      vertices: new Float32Array([-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1].map((x) => 1e-3 * x)),
      centre: [0, 0, 0],
      radiusM: 1.5e-3,
    },
  }) as unknown as Body;

const model = (...objects: Body[]): SceneModel => ({objects}) as unknown as SceneModel;
const touched = (scene: SceneModel, points: readonly ContactPoint[], moved: readonly Pose[] = []) =>
  touchedObjects(scene, {points, moved});
const at = (positionM: Vec3, newtons: number) => ({positionM, forceN: [0, newtons, 0] as Vec3});

test("what pushes hardest comes first, and what only lies near does not come", () => {
  const scene = model(plate("tooth-36", 0), plate("gingiva", 5e-3), plate("far", 1));
  const points = [at([0, 5e-3, 0], 1), at([0, 1e-4, 0], 0.6), at([0, 0, 1e-3], 0.7)];
  expect(touched(scene, points)).toEqual(["tooth-36", "gingiva"]);
  expect(touched(scene, [at([0, 0, 0], 0)])).toEqual([]);
  expect(touched(scene, [at([0, 0.5, 0], 1)])).toEqual([]);
});

test("an object is found where its pose has it", () => {
  const turned = plate("turned", 0, [Math.SQRT1_2, Math.SQRT1_2, 0, 0]); // y to z
  const points = [at([0, -1e-3, 1e-4], 1)];
  expect(touched(model(turned, plate("above", 1.6e-3)), points)).toEqual(["turned"]);
});

test("an object is found where its group has moved it", () => {
  const jaw = {...plate("jaw", 0), moved: 1};
  const scene = model(jaw, plate("still", 4e-3));
  const points = [at([0, 3e-3, 0], 1)];
  expect(touched(scene, points)).toEqual(["still"]);
  expect(touched(scene, points, [{p: [0, 3e-3, 0], q: [1, 0, 0, 0]}])).toEqual(["jaw"]);
});

test("the force stands where the contacts push, each by its share", () => {
  expect(middleOfPush([])).toBeUndefined();
  expect(middleOfPush([at([1, 2, 3], 0)])).toBeUndefined();
  expect(middleOfPush([at([0, 0, 0], 1), at([4, 0, 8], 3)])).toEqual([3, 0, 6]);
});

test("what is touched is said in a word or two", () => {
  expect(touchedWords([])).toBe("nothing");
  expect(touchedWords(["tooth-36"])).toBe("tooth 36");
  expect(touchedWords(["tooth-36", "gum"])).toBe("tooth 36, gum");
  expect(touchedWords(["a", "b", "c"])).toBe("a and 2 more");
});
