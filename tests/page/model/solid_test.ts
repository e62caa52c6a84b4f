import {expect, test, vi} from "vitest";

import type {SceneModel} from "@page/model/bundle";
import {Remains, removedByTissue} from "@page/model/remains";
import {readBlock} from "@page/model/solid";
import {World} from "@page/model/world";
import {toSolidBlock} from "@page/protocol/messages";

import {kPitBlock, pit, solidBlock, surfaceCode} from "../support/solid_blocks";

const told = (block: number, change: number, surface = pit(), more: object = {}) =>
  toSolidBlock({...solidBlock("cube", block, change, surface), ...more});

const kTriangle = [
  [0, 1, 2],
  [2, 1, 0],
] as const;
const place = (x: number) => [x, 0.5, -1.5] as const;

test("a block's bytes come out as they went in, with narrow numbers and with wide ones", () => {
  for (const count of [3, 256, 257]) {
    const vertices = Array.from({length: count}, (_, i) => place(0.25 * (i % 40)));
    const last = [0, 1, count - 1] as const;
    const {surface, ...rest} = told(5, 1, surfaceCode(vertices, [last, ...kTriangle], [1, 2, 3]));
    // Wherever they lie.
    const shifted = new Uint8Array(surface.length + 1).subarray(1);
    shifted.set(surface);
    const block = readBlock({...rest, surface: shifted})!;
    expect(block.vertices.length).toBe(3 * count);
    expect([...block.vertices.subarray(3, 6)]).toEqual([47, 53, 11]);
    expect([...block.triangles.subarray(0, 3)]).toEqual(last);
    expect([...block.materials]).toEqual([1, 2, 3]);
  }
});

test("what is removed is the sum of the newest blocks, by tissue, and nothing once the scene is whole", () => {
  const remains = new Remains();
  const tell = (block: number, change: number, removed: readonly number[], object = 0): void =>
    void remains.cut(told(block, change, pit(), {removed_mm3: removed, object_index: object}));
  tell(5, 1, [1, 2]);
  tell(5, 3, [1.5, 2]);
  tell(5, 2, [9, 9]); // came late
  tell(6, 4, [0.25]);
  tell(7, 5, [0, 0.125, 4]);
  tell(5, 6, [8], 1);
  const model = {objects: [{tissues: ["enamel", "pulp", "enamel"]}, {tissues: ["pulp"]}]};
  const removed = (): object =>
    Object.fromEntries(removedByTissue(model as unknown as SceneModel, remains));
  expect(removed()).toEqual({enamel: 1.5 + 0.25 + 4, pulp: 2 + 0.125 + 8});
  remains.undo(6);
  expect(removed()).toEqual({enamel: 0, pulp: 0});
});

test("a block may be empty, which also is a cut", () => {
  const block = readBlock(told(5, 1, new Uint8Array(6)))!;
  expect(block.triangles.length).toBe(0);
  expect(block.cut).toBe(true);
});

test("a quad is two triangles, of what lies behind it", () => {
  const surface = Uint8Array.from([
    ...[4, 0, 1, 0, 1, 0], // vertices, quads, triangles
    ...[42, 42, 42, 63, 42, 42, 63, 63, 42, 42, 63, 42],
    ...[0, 1, 2, 3],
    ...[3, 2, 0],
    ...[7, 5],
  ]);
  const block = readBlock(told(5, 1, surface))!;
  expect([...block.triangles]).toEqual([0, 1, 2, 0, 2, 3, 3, 2, 0]);
  expect([...block.materials]).toEqual([7, 7, 5]);
});

test("damaged bytes are no block", () => {
  const whole = pit();
  for (let length = 0; length < whole.length; length++) {
    // But for one material, which would stand for all.
    if (length === whole.length - 17) continue;
    expect(readBlock(told(5, 1, whole.slice(0, length))), `${length} bytes`).toBeUndefined();
  }
  const beyond = surfaceCode([0, 1, 2].map(place), [[0, 1, 3]]);
  expect(readBlock(told(5, 1, beyond))).toBeUndefined();
  const many = surfaceCode(
    Array.from({length: 5917}, () => place(0)),
    kTriangle,
  );
  expect(readBlock(told(5, 1, many))).toBeUndefined();
});

test("what is left of a block is the newest word of it, in whatever order they come", () => {
  const remains = new Remains();
  expect(remains.isWhole).toBe(true);
  for (const change of [3, 7, 5]) expect(remains.cut(told(kPitBlock, change))).toBe(true);
  remains.cut(told(2, 4));
  const solid = remains.solidOf(0)!;
  expect([...solid.blocks].map(([block, {change}]) => [block, change])).toEqual([
    [kPitBlock, 7],
    [2, 4],
  ]);
  expect(remains.isWhole).toBe(false);
  expect(remains.solidOf(1)).toBeUndefined();
});

test("cuts that are undone are gone, whether they come before or after the word of it", () => {
  const remains = new Remains();
  remains.cut(told(2, 4));
  remains.cut(told(kPitBlock, 9));
  const {version} = remains.solidOf(0)!;
  remains.undo(6);
  remains.cut(told(3, 5));
  expect([...remains.solidOf(0)!.blocks.keys()]).toEqual([kPitBlock]);
  expect(remains.solidOf(0)!.version).not.toBe(version);
  remains.undo(9);
  expect(remains.isWhole).toBe(true);
});

test("a block of no lattice, or of another one than the others', is not taken", () => {
  const remains = new Remains();
  expect(remains.cut(told(64, 1))).toBe(false);
  expect(remains.cut(told(2, 1, pit(), {spacing_m: 0}))).toBe(false);
  expect(remains.cut(told(2, 1, pit(), {blocks: [1e6, 1e6, 1e6]}))).toBe(false);
  expect(remains.cut(told(2, 1))).toBe(true);
  expect(remains.cut(told(3, 2, pit(), {blocks: [5, 4, 4]}))).toBe(false);
});

test("damage is said once, and what came before it stays; another server's scenes are whole", () => {
  const warn = vi.spyOn(console, "warn").mockImplementation(() => {});
  const changes: string[] = [];
  const world = new World((change, scene) => void changes.push(`${change} ${scene}`));
  const say = (change: number, surface: Uint8Array, serverRun = 1n): void =>
    world.receive("solid_block", solidBlock("cube", kPitBlock, change, surface, {serverRun}), 0, 0);
  say(1, pit());
  say(2, new Uint8Array(7));
  say(3, new Uint8Array(7));
  expect(warn.mock.calls).toEqual([[expect.stringMatching(/block 45 of object 0 .* cube/)]]);
  expect(changes[0]).toBe("remains cube");
  expect(world.remainsOf("cube").solidOf(0)!.blocks.get(kPitBlock)!.change).toBe(1);
  say(1, new Uint8Array(6), 2n);
  const {blocks} = world.remainsOf("cube").solidOf(0)!;
  expect(blocks.get(kPitBlock)!.triangles.length).toBe(0);
  warn.mockRestore();
});
