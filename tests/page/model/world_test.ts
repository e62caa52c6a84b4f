import {expect, test} from "vitest";

import {kTopics, World} from "@page/model/world";

const state = (station: string, sequence: number, more: object = {}) => ({
  station,
  scene: "cube",
  tool: "ball",
  pose_sequence: sequence,
  ...more,
});
const session = (station: string, phase: number, more: object = {}) => ({
  station,
  phase,
  scene: "cube",
  tool: "ball",
  server_run: 1n,
  ...more,
});

test("a scene is known from whatever tells of it, once", () => {
  const told: string[] = [];
  const world = new World((change, scene) => {
    if (change === "scenes") told.push(scene);
  });
  world.receive(kTopics.toolState, state("hand", 1), 1, 1);
  world.receive(kTopics.sessionState, session("hand", 2), 1, 1);
  world.addScene("pipes");
  expect(told).toEqual(["cube", "pipes"]);
});

test("the station with the tool comes before one that has left", () => {
  const world = new World(() => {});
  world.receive(kTopics.sessionState, session("aaa", 4), 0, 0);
  world.receive(kTopics.sessionState, session("zzz", 2), 0, 0);
  expect(world.listed(10).map(({id}) => id)).toEqual(["zzz", "aaa"]);
  expect(world.holderOf("cube", "ball")?.id).toBe("zzz");
  expect(world.holderOf("cube", "other")).toBeUndefined();
});

test("a station that was refused neither holds a tool nor names a scene", () => {
  const world = new World(() => {});
  world.receive(kTopics.sessionState, session("late", 3, {scene: "nowhere"}), 0, 0);
  expect(world.holderOf("nowhere", "ball")).toBeUndefined();
  expect(world.scenes.has("nowhere")).toBe(false);
});

test("a tool stays where its last mover left it", () => {
  const world = new World(() => {});
  world.receive(kTopics.toolState, state("first", 10), 1, 1);
  world.receive(kTopics.toolState, state("second", 5), 2, 2);
  expect(world.lastMoverOf("cube", "ball")?.id).toBe("second");
  expect(world.stations.get("first")!.isMoving(2.6)).toBe(false);
});

test("sessions are forgotten with the link, stations are not", () => {
  const world = new World(() => {});
  world.receive(kTopics.toolState, state("hand", 1), 1, 1);
  world.receive(kTopics.sessionState, session("hand", 2), 1, 1);
  world.forgetSessions();
  expect(world.holderOf("cube", "ball")).toBeUndefined();
  expect(world.stations.get("hand")!.track.latest?.poseSequence).toBe(1);
});

test("a server's new run makes a scraped scene whole, and worth another look", () => {
  const runs: string[] = [];
  const world = new World((change, scene) => {
    if (change === "serverRun") runs.push(scene);
  });
  const change = {
    scene: "cube",
    change: 1n,
    server_run: 1n,
    object_index: 0,
    leaf: 4,
    triangles: 1,
    triangle: [9],
  };
  world.receive(kTopics.sceneChange, change, 0, 0);
  expect(world.scenes.get("cube")!.leavesOf(0).size).toBe(1);
  world.receive(kTopics.sessionState, session("hand", 2, {server_run: 2n}), 0, 0);
  expect(world.scenes.get("cube")!.leavesOf(0).size).toBe(0);
  expect(runs).toEqual(["cube"]);
});
