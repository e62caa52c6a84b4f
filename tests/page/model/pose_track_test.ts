import {describe, expect, test} from "vitest";

import {looksTheSame, PoseTrack, StreamClock} from "@page/model/pose_track";
import {toToolState, type ToolState} from "@page/protocol/messages";

const at = (sequence: number, x: number): ToolState => ({
  ...toToolState({station: "hand", tool: "ball", pose_sequence: sequence}),
  graphic: {p: [x, 0, 0], q: [1, 0, 0, 0]},
  haptic: {p: [x, -1, 0], q: [1, 0, 0, 0]},
  forceN: [2 * x, 0, 0],
});

describe("a track", () => {
  test("lies between its frames where the moment does", () => {
    const track = new PoseTrack();
    expect(track.at(1)).toBeUndefined();
    track.push(1.0, at(1, 0));
    track.push(1.1, at(2, 10));
    expect(track.at(1.025)?.graphic.p[0]).toBeCloseTo(2.5, 9);
    expect(track.at(1.05)?.haptic.p).toEqual([expect.closeTo(5, 9), -1, 0]);
    expect(track.at(1.05)?.forceN[0]).toBeCloseTo(10, 9);
    // Never beyond its newest frame, nor before its oldest.
    expect(track.at(5)?.graphic.p[0]).toBe(10);
    expect(track.at(0)?.graphic.p[0]).toBe(0);
  });

  test("jumps over a gap and does not glide", () => {
    const track = new PoseTrack();
    track.push(1.0, at(1, 0));
    track.push(2.0, at(2, 10));
    expect(track.at(1.9)?.graphic.p[0]).toBe(0);
    expect(track.at(2.0)?.graphic.p[0]).toBe(10);
  });

  test("drops a frame that comes after a later one", () => {
    const track = new PoseTrack();
    track.push(1.0, at(7, 1));
    track.push(0.98, at(6, 99));
    expect(track.latest?.poseSequence).toBe(7);
  });

  test("starts anew with a station that counts from the beginning again", () => {
    const track = new PoseTrack();
    track.push(100, at(5000, 1));
    track.push(3, at(1, 2));
    expect(track.latest?.graphic.p[0]).toBe(2);
    expect(track.at(3)?.graphic.p[0]).toBe(2);
  });
});

describe("a stream's clock", () => {
  test("takes out what frames were late by", () => {
    const clock = new StreamClock();
    const local = [0, 1, 2, 3].map((i) =>
      clock.toLocal(500 + i / 30, 10 + i / 30 + [0, 0.02, 0.005, 0.03][i]!),
    );
    for (let i = 1; i < 4; i++) expect(local[i]! - local[i - 1]!).toBeCloseTo(1 / 30, 2);
  });

  test("keeps the distances of frames that waited while the page was busy", () => {
    const clock = new StreamClock();
    clock.toLocal(500, 10);
    const waited = [501, 501.5, 502].map((stamp) => clock.toLocal(stamp, 12.1));
    expect(waited[1]! - waited[0]!).toBeCloseTo(0.5, 1);
    expect(waited[2]!).toBeCloseTo(12, 1);
  });

  test("follows a sender that starts with another clock", () => {
    const clock = new StreamClock();
    clock.toLocal(500, 10);
    expect(clock.toLocal(3, 11)).toBeCloseTo(11, 6);
    expect(clock.toLocal(90_000, 12)).toBeCloseTo(12, 6);
  });
});

test("what cannot be seen is the same, what can is not", () => {
  const state = at(1, 0.1);
  expect(looksTheSame(state, at(2, 0.1))).toBe(true);
  expect(looksTheSame(state, at(2, 0.1 + 1e-9))).toBe(true);
  expect(looksTheSame(state, at(2, 0.1001))).toBe(false);
  const touching = {...state, points: [{positionM: [0, 0, 0], forceN: [0, 1, 0]}] as const};
  expect(looksTheSame(touching, {...touching, points: [...touching.points]})).toBe(true);
  expect(looksTheSame(state, touching)).toBe(false);
  expect(looksTheSame(state, {...state, buttons: 2})).toBe(false);
  expect(looksTheSame(undefined, undefined)).toBe(true);
  expect(looksTheSame(undefined, state)).toBe(false);
});
