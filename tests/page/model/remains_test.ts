import {expect, test} from "vitest";

import {Remains} from "@page/model/remains";
import type {SceneChange} from "@page/protocol/messages";

const change = (
  number: number,
  triangles: number[],
  more: Partial<SceneChange> = {},
): SceneChange => ({
  scene: "calculus",
  change: number,
  serverRun: "a",
  objectIndex: 1,
  leaf: number,
  triangles,
  ...more,
});

test("what goes adds up, in whatever order and however often it is told", () => {
  const remains = new Remains();
  for (const number of [3, 1, 2, 1]) remains.apply(change(number, [10 * number, 10 * number + 1]));
  expect([...remains.trianglesOf(1)].sort((a, b) => a - b)).toEqual([10, 11, 20, 21, 30, 31]);
  expect([...remains.leavesOf(1)].sort()).toEqual([1, 2, 3]);
  expect(remains.trianglesOf(0).size).toBe(0);
});

test("what was undone stays so, whether the changes come before or after the word of it", () => {
  const before = new Remains();
  const after = new Remains();
  for (const number of [1, 2, 3]) before.apply(change(number, [number]));
  before.undo(2);
  after.undo(2);
  for (const number of [3, 2, 1]) after.apply(change(number, [number]));
  for (const remains of [before, after]) {
    expect([...remains.leavesOf(1)]).toEqual([3]);
    expect([...remains.trianglesOf(1)]).toEqual([3]);
    expect(remains.isWhole).toBe(false);
    remains.undo(3);
    expect(remains.isWhole).toBe(true);
    // The same leaf goes again, by another change.
    remains.apply(change(4, [3], {leaf: 3}));
    expect([...remains.leavesOf(1)]).toEqual([3]);
  }
});

test("what is whole again has nothing gone", () => {
  const remains = new Remains();
  remains.apply(change(1, [1]));
  remains.clear();
  expect(remains.leavesOf(1).size).toBe(0);
  expect(remains.trianglesOf(1).size).toBe(0);
});
