import {expect, test} from "vitest";

import {markAfter, markBefore, Replay} from "@page/model/replay";
import type {ReplayContents} from "@page/protocol/messages";

import {replayState} from "../support/replay_state";

const kState = replayState(10);
const kContents: ReplayContents = {
  replay: "ab",
  recording: "lesson.mcap",
  begunS: 1.7e9,
  lengthS: 60,
  locked: false,
  marks: [],
  gaps: [],
};

test("a page that has heard of no replay sees none, whatever it knows of one's contents", () => {
  const replay = new Replay();
  expect(replay.phase(5)).toBe("none");
  replay.receiveContents(kContents);
  expect(replay.phase(5)).toBe("none");
  expect(replay.contents).toBeUndefined();
  replay.receiveState(kState, 1000, 5);
  expect(replay.contents?.recording).toBe("lesson.mcap");
});

test("a replay plays, is paused, falls silent after three seconds, and ends", () => {
  const replay = new Replay();
  replay.receiveState(kState, 1000, 5);
  expect(replay.phase(7.9)).toBe("playing");
  expect(replay.phase(8.1)).toBe("silent");
  expect(replay.phase(8.1, 7)).toBe("playing"); // the page did not run before 7
  replay.receiveState({...kState, playing: false}, 1001, 9);
  expect(replay.phase(9)).toBe("paused");
  replay.receiveState({...kState, ended: true}, 1001, 10);
  expect(replay.phase(10)).toBe("ended");
  expect(replay.phase(100)).toBe("ended");
});

test("time goes on between two states at the replay's rate, and not far beyond nor past the end", () => {
  const replay = new Replay();
  replay.receiveContents(kContents);
  replay.receiveState({...kState, rate: 2}, 1000, 5);
  expect(replay.atS(5.1)).toBeCloseTo(10.2, 9);
  expect(replay.atS(50)).toBeCloseTo(12, 9);
  expect(replay.timeOf(999.5)).toBeCloseTo(9, 9);
  replay.receiveState({...kState, atS: 59.9}, 1000, 100);
  expect(replay.atS(100.8)).toBe(60);
  replay.receiveState({...kState, playing: false}, 1000, 200);
  expect(replay.atS(200.5)).toBe(10);
  expect(replay.timeOf(1001)).toBe(10);
});

test("a leap is told from the way that time goes", () => {
  const replay = new Replay();
  expect(replay.receiveState(kState, 1000, 5)).toBe(true);
  expect(replay.receiveState({...kState, atS: 10.2}, 1000.2, 5.9)).toBe(false); // it was read late
  expect(replay.receiveState({...kState, atS: 10.2}, 1001, 5.9)).toBe(false); // it was held up
  expect(replay.receiveState({...kState, atS: 10.0}, 1000.3, 6)).toBe(true);
  expect(replay.receiveState({...kState, atS: 10.3}, 1000.6, 6.3)).toBe(false);
  expect(replay.receiveState({...kState, atS: 11.2}, 1000.8, 6.5)).toBe(true);
  expect(replay.receiveState({...kState, atS: 11.4, rate: 8}, 1001, 6.7)).toBe(false);
  expect(replay.receiveState({...kState, atS: 13.5, rate: 8}, 1001.2, 6.9)).toBe(false);
});

test("of two replays at once the first is shown until it is over", () => {
  const replay = new Replay();
  replay.receiveState(kState, 1000, 5);
  replay.receiveState({...kState, replay: "cd", atS: 50}, 1000, 5.1);
  expect(replay.state?.replay).toBe("ab");
  expect(replay.receiveState({...kState, replay: "cd", atS: 10}, 1000, 9)).toBe(true);
  expect(replay.state?.replay).toBe("cd");
});

test("a locked replay is not steered, nor one that is over, nor one of which nothing is known", () => {
  const replay = new Replay();
  replay.receiveState(kState, 1000, 5);
  expect(replay.isSteered(5)).toBe(false);
  replay.receiveContents(kContents);
  expect(replay.isSteered(5)).toBe(true);
  expect(replay.isSteered(9)).toBe(false);
  replay.receiveContents({...kContents, locked: true});
  expect(replay.isSteered(5)).toBe(false);
});

test("marks are found before and after a moment, and going back twice goes on", () => {
  const marks = [1, 5, 9].map((atS) => ({atS, number: 0, kind: "contact", text: ""}) as const);
  expect(markAfter(marks, 0)?.atS).toBe(1);
  expect(markAfter(marks, 5)?.atS).toBe(9);
  expect(markAfter(marks, 9)).toBeUndefined();
  expect(markBefore(marks, 5.5, 1)?.atS).toBe(1);
  expect(markBefore(marks, 5.5, 0.25)?.atS).toBe(5);
  expect(markBefore(marks, 9.9, 1)?.atS).toBe(9);
  expect(markBefore(marks, 1, 1)).toBeUndefined();
  expect(markBefore(marks, 5.001, 0)?.atS).toBe(1); // it stands at 5
});
