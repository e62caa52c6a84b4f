import {expect, test} from "vitest";

import {World} from "@page/model/world";

import {replayStateSent} from "../support/replay_state";
import {kPitBlock, pit, solidBlock} from "../support/solid_blocks";

const state = (station: string, sequence: number, more: object = {}) => ({
  station,
  scene: "cube",
  tool: "ball",
  pose_sequence: sequence,
  ...more,
});
const health = (scenes: string[], server_run: string) => ({
  ...{scenes, server_run, server_lives: true, compiling: null, viewers: 1, max_viewers: 300},
});
const session = (station: string, phase: number, more: object = {}) => ({
  station,
  phase,
  scene: "cube",
  tool: "ball",
  server_run: 1n,
  ...more,
});

test("a goal is a scene's, and the last that was set counts", () => {
  const told: string[] = [];
  const world = new World((change, scene) => {
    if (change === "goal") told.push(scene);
  });
  world.receive("goal", {scene: "cube", text: "Press", limit_N: 1}, 1, 1);
  world.receive("goal", {scene: "pipes", text: "Go through", limit_N: 0}, 2, 2);
  world.receive("goal", {scene: "cube", text: "Press gently", limit_N: 0.5}, 3, 3);
  expect(world.goals.get("cube")).toEqual({scene: "cube", text: "Press gently", limitN: 0.5});
  expect(world.goals.get("pipes")?.text).toBe("Go through");
  expect(world.goals.get("bunny")).toBeUndefined();
  expect(told).toEqual(["cube", "pipes", "cube"]);
});

test("scenes are what the gateway has, and no others", () => {
  let told = 0;
  const world = new World((change) => {
    if (change === "scenes") told += 1;
  });
  world.receiveHealth(health(["cube", "pipes"], "1"));
  world.receiveHealth(health(["cube", "pipes"], "1"));
  expect(told).toBe(1);
  world.receive("tool_state", state("hand", 1, {scene: "typo"}), 1, 1);
  world.receiveHealth(health(["pipes"], "1"));
  expect([...world.scenes]).toEqual(["pipes"]);
  expect(told).toBe(2);
});

test("what moves by itself is drawn with the tool at the same moments", () => {
  const world = new World(() => {});
  const turned = [Math.SQRT1_2, Math.SQRT1_2, 0, 0];
  const moved = (x: number, orientation_wxyz: number[]) => ({
    scene: "cube",
    moved: [{position_m: [x, 0, 0], orientation_wxyz}],
  });
  world.receive("moved_state", moved(0, [1, 0, 0, 0]), 1, 1);
  world.receive("tool_state", state("hand", 1), 1, 1);
  world.receive("moved_state", moved(0.002, turned), 1.02, 1.02);
  world.receive("tool_state", state("hand", 2), 1.02, 1.02);
  world.receive("tool_state", state("other", 1, {scene: "pipes"}), 1.02, 1.02);
  const {track} = world.stations.get("hand")!;
  expect(track.at(1.01)!.moved[0]!.p[0]).toBeCloseTo(0.001, 9);
  expect(track.at(1.01)!.moved[0]!.q[1]).toBeCloseTo(Math.sin(Math.PI / 8), 9);
  expect(track.latest!.moved[0]!.q).toEqual(turned);
  expect(world.stations.get("other")!.track.latest!.moved).toEqual([]);
});

test("the station with the tool comes before one that has left", () => {
  const world = new World(() => {});
  world.receive("session_state", session("aaa", 4), 0, 0);
  world.receive("session_state", session("zzz", 2), 0, 0);
  expect(world.listed(10).map(({id}) => id)).toEqual(["zzz", "aaa"]);
  expect(world.holderOf("cube", "ball")?.id).toBe("zzz");
  expect(world.holderOf("cube", "other")).toBeUndefined();
  world.receive("session_state", session("late", 3, {scene: "nowhere"}), 0, 0);
  expect(world.holderOf("nowhere", "ball")).toBeUndefined(); // it was refused
});

test("a tool stays where its last mover left it", () => {
  const world = new World(() => {});
  world.receive("tool_state", state("first", 10), 1, 1);
  world.receive("tool_state", state("second", 5), 2, 2);
  expect(world.lastMoverOf("cube", "ball")?.id).toBe("second");
  expect(world.stations.get("first")!.isMoving(2.6)).toBe(false);
});

test("a station's next run begins anew, wherever the former one left its tool", () => {
  const world = new World(() => {});
  const own = () => world.stations.get("anna")!.own?.poseSequence;
  world.receive("session_state", session("anna", 2, {run: 1n}), 0, 0);
  world.receive("tool_state", state("anna", 10), 1, 1);
  world.receive("session_state", session("anna", 4, {run: 1n}), 2, 2);
  expect(own()).toBe(10);
  world.startLink();
  world.receive("session_state", session("anna", 1, {run: 2n}), 3, 3);
  expect(own()).toBeUndefined();
  expect(world.lastMoverOf("cube", "ball")?.id).toBe("anna"); // there it is seen
  world.receive("tool_state", state("anna", 1), 4, 4);
  expect(own()).toBe(1);
});

test("sessions are forgotten with the link, stations are not", () => {
  const world = new World(() => {});
  world.receive("tool_state", state("hand", 1), 1, 1);
  world.receive("session_state", session("hand", 2), 1, 1);
  world.startLink();
  expect(world.holderOf("cube", "ball")).toBeUndefined();
  expect(world.stations.get("hand")!.track.latest?.poseSequence).toBe(1);
});

/// A world, and how often a new run of the server was told.
function worldOfRuns() {
  const runs = {told: 0};
  const world = new World((change) => {
    if (change === "serverRun") runs.told += 1;
  });
  return {world, runs};
}
test("a server's new run makes a cut scene whole, and any worth another look", () => {
  const {world, runs} = worldOfRuns();
  world.receive("session_state", session("hand", 2, {server_run: 1n}), 0, 0);
  world.receive("solid_block", solidBlock("cube", kPitBlock, 1, pit()), 0, 0);
  expect(world.remainsOf("cube").isWhole).toBe(false);
  world.receive("session_state", session("hand", 2, {server_run: 2n}), 0, 0);
  expect(world.remainsOf("cube").isWhole).toBe(true);
  expect(runs.told).toBe(1);
  world.receive("solid_block", solidBlock("cube", kPitBlock, 1, pit()), 0, 0);
  expect(world.remainsOf("cube").isWhole).toBe(true); // the former's last word
  world.receive("session_state", session("hand", 2, {server_run: 3n}), 0, 0);
  expect(runs.told).toBe(2); // though nothing was cut
});

test("who held a tool of a server that is gone holds nothing of its successor's", () => {
  const {world, runs} = worldOfRuns();
  world.receiveHealth(health(["cube"], "a"));
  world.receive("session_state", session("hand", 2, {server_run: 10n}), 0, 0); // "a", too
  expect(world.holderOf("cube", "ball")?.id).toBe("hand");
  world.receiveHealth(health([], "0")); // the gateway itself has begun anew, and knows no server
  expect(world.holderOf("cube", "ball")?.id).toBe("hand");
  world.receiveHealth(health(["cube"], "b"));
  expect(world.holderOf("cube", "ball")).toBeUndefined();
  world.receiveHealth(health(["cube"], "a")); // an answer that was long on its way
  world.receive("session_state", session("new", 2, {server_run: 11n}), 0, 0);
  expect(world.holderOf("cube", "ball")?.id).toBe("new");
  expect(runs.told).toBe(1);
});

test("a tool that nothing moves any more stands where it was, without a force", () => {
  const world = new World(() => {});
  const pressed = state("hand", 1, {
    haptic_position_m: [0, -0.01, 0],
    force_N: [0, 5, 0],
    torque_Nm: [1, 0, 0],
    contacts: 1,
    points: 1,
    point: [{position_m: [0, 0, 0], force_N: [0, 5, 0]}],
  });
  world.receive("tool_state", pressed, 1, 1);
  const hand = world.stations.get("hand")!;
  expect(hand.shown(1.1)).toMatchObject({forceN: [0, 5, 0], haptic: {p: [0, -0.01, 0]}});
  expect(hand.shown(5)).toMatchObject({
    forceN: [0, 0, 0],
    torqueNm: [0, 0, 0],
    points: [],
    haptic: {p: [0, 0, 0]},
    graphic: {p: [0, 0, 0]},
  });
});

test("between two frames is where the picture is, however seldom they come", () => {
  for (const rate of [10, 30, 60]) {
    const world = new World(() => {});
    let time = 0;
    for (let i = 0; i < 100; i++) {
      time += 1 / rate;
      world.receive("tool_state", state("hand", i, {graphic_position_m: [time, 0, 0]}), time, time);
    }
    const hand = world.stations.get("hand")!;
    // Just before the next frame comes there is still one ahead of the picture.
    expect(hand.isCatchingUp(time + 0.99 / rate), `${rate} Hz`).toBe(true);
    const shown = hand.shown(time + 0.5 / rate)!.graphic.p[0];
    expect(shown).toBeLessThan(time);
    expect(shown).toBeGreaterThan(time - 0.06 - 1.6 / rate);
  }
});

const force = (world: World, nowS: number): [number[], number[]] =>
  world.stations.get("hand")!.history.series(0, nowS);

test("a replay's figures stand at the recording's times", () => {
  const world = new World(() => {});
  world.receive("tool_state", state("hand", 1), 900, 1); // nobody knows of a replay yet
  world.receive("replay_state", replayStateSent(40, {rate: 0.5}), 1000, 2);
  // However late the page comes to read them.
  world.receive("tool_state", state("hand", 2), 1000.2, 2.9);
  world.receive("tool_state", state("hand", 3), 1000.4, 2.9);
  const [times] = force(world, 40);
  expect(times.map((time) => time + 40)).toEqual([
    40, // of what was shown as it became known
    expect.closeTo(40.1, 6),
    expect.closeTo(40.2, 6),
  ]);
});

test("the plots begin anew where a replay goes elsewhere, with what it shows there", () => {
  const world = new World(() => {});
  world.receive("replay_state", replayStateSent(40), 1000, 1);
  world.receive("tool_state", state("hand", 1), 1000.1, 1.1);
  world.receive("replay_state", replayStateSent(40.2), 1000.2, 1.2);
  expect(force(world, 40.2)[0].length).toBe(1);
  // A seek while it is paused: one state of the tool, and then where it is.
  world.receive("tool_state", state("hand", 2, {force_N: [7, 0, 0]}), 1000.3, 1.3);
  world.receive("replay_state", replayStateSent(12, {playing: false}), 1000.31, 1.31);
  expect(force(world, 12)).toEqual([[0], [7]]);
  // On again: what was shown before the leap is none of it.
  world.receive("replay_state", replayStateSent(30), 1003, 4);
  expect(force(world, 30)).toEqual([[], []]);
});

test("a tool is not left alone while a replay is paused", () => {
  const world = new World(() => {});
  world.receive("replay_state", replayStateSent(40), 1000, 1);
  world.receive("session_state", session("hand", 2), 1000, 1);
  world.receive("tool_state", state("hand", 1), 1000, 1);
  for (let nowS = 1.2; nowS < 20; nowS += 0.2) {
    world.receive("replay_state", replayStateSent(40.2, {playing: false}), 999 + nowS, nowS);
  }
  expect(world.stations.get("hand")!.isMoving(20)).toBe(true);
  expect(world.stations.get("hand")!.isMoving(22)).toBe(false);
  // It is sent to where nobody had the tool: as another server, and of no session.
  world.receive("session_state", session("other", 2, {server_run: 2n}), 1021, 22);
  world.receive("tool_state", state("hand", 2), 1021, 22);
  for (let nowS = 22.2; nowS < 25; nowS += 0.2) {
    world.receive("replay_state", replayStateSent(0, {playing: false}), 999 + nowS, nowS);
  }
  expect(world.stations.get("hand")!.isMoving(25)).toBe(false);
});

test("what another server says after a replay is live, and while it plays it is the replay's", () => {
  const world = new World(() => {});
  world.receive("session_state", session("hand", 2, {server_run: 1n}), 0, 0);
  world.receive("replay_state", replayStateSent(40), 1000, 1);
  world.receive("session_state", session("hand", 2, {server_run: 2n}), 1000, 1);
  expect(world.replay.phase(1)).toBe("playing");
  world.receive("replay_state", replayStateSent(41, {ended: true}), 1001, 2);
  expect(world.replay.phase(60)).toBe("ended");
  world.receiveHealth(health(["cube"], "3"), 60);
  expect(world.replay.phase(60)).toBe("none");
  // Likewise after one that has only fallen silent.
  world.receive("replay_state", replayStateSent(40), 2000, 100);
  world.receiveHealth(health(["cube"], "4"), 101);
  expect(world.replay.phase(101)).toBe("playing");
  world.receiveHealth(health(["cube"], "5"), 110);
  expect(world.replay.phase(110)).toBe("none");
});

test("a station that goes to another scene brings neither its place nor its forces along", () => {
  const world = new World(() => {});
  const at = (x: number, more: object): object =>
    state("mouse", 1, {
      ...{graphic_position_m: [x, 0, 0], graphic_orientation_wxyz: [1, 0, 0, 0]},
      ...{haptic_position_m: [x, 0, 0], haptic_orientation_wxyz: [1, 0, 0, 0]},
      ...{force_N: [3, 0, 0], torque_Nm: [0, 0, 0], ...more},
    });
  world.receive("tool_state", at(1, {}), 1, 1);
  world.receive("tool_state", at(2, {scene: "pipes", force_N: [0, 0, 0]}), 1.03, 1.03);
  const mouse = world.stations.get("mouse")!;
  // The picture is a little behind the newest frame.
  expect(mouse.shown(1.03)).toMatchObject({scene: "pipes", graphic: {p: [2, 0, 0]}});
  expect(mouse.history.series(0, 1.03)[1]).toEqual([0]);
});
