import {readFileSync} from "node:fs";

import {parseIDL} from "@foxglove/omgidl-parser";
import {MessageWriter} from "@foxglove/omgidl-serialization";
import {expect, test} from "vitest";

import {makeDecoder} from "@page/protocol/decoder";
import {
  toLoopStatistics,
  toMouseState,
  toSessionState,
  toSolidBlock,
  toStationStatistics,
  toToolState,
} from "@page/protocol/messages";

import {
  encode,
  kChannels,
  loopStatistics,
  sessionState,
  stationStatistics,
  toolState,
} from "../support/fake_gateway";
import {kPitBlock, pit, solidBlock} from "../support/solid_blocks";

const channel = (topic: string) => kChannels.find((candidate) => candidate.topic === topic)!;
const through = (topic: string, value: object): unknown =>
  makeDecoder(channel(topic))!(encode(topic, value));

test("what servers and stations say comes out as it went in", () => {
  const state = {
    ...{station: "hand", scene: "bunny-bunny", tool: "bunny", poseSequence: 2 ** 40 + 1},
    haptic: {p: [1, 2, 3], q: [0.5, 0.5, -0.5, 0.5]},
    graphic: {p: [4, 5, 6], q: [1, 0, 0, 0]},
    forceN: [0.1, 0.2, 0.3],
    torqueNm: [0.4, 0.5, 0.6],
    points: [{positionM: [7, 8, 9], forceN: [-1, -2, -3]}],
    buttons: 3,
  } as const;
  expect(toToolState(through("/palpate/tool_state", toolState(state)))).toEqual({
    ...state,
    contacts: 1,
    moved: [],
    stepUs: 9.5,
  });
  const refused = sessionState("hand", "refused", "cube", "ball", {reason: "taken"});
  expect(toSessionState(through("/palpate/session_state", refused))).toMatchObject({
    ...{station: "hand", phase: "refused", reason: "taken"},
  });
  const loop = loopStatistics("hand", "cube", {late: 3n});
  expect(toLoopStatistics(through("/palpate/loop_statistics", loop))).toMatchObject({
    ...{rateHz: 1000, late: 3, stepUs: {p50: 9.1, p999: 22.8}},
  });
  const arm = stationStatistics("hand", {braked: 30n, disabled: 7n, lost: 2n, device_status: 5});
  expect(toStationStatistics(through("/palpate/station_statistics", arm))).toEqual({
    ...{station: "hand", device: "PHANTOM Premium 3.0", ticks: 1000, replies: 1000},
    ...{late: 0, lost: 2, silenceS: 0.0012, wantedForceN: 2, appliedForceN: 2},
    limiter: {nonfinite: 0, clamped: 0, slewed: 0, braked: 30, warm: 0, faded: 0, disabled: 7},
    ...{energyJ: 0.0125, energyLeastJ: 0, warmth: 0.21, deviceStatus: 5},
  });
  const more = {object: 2, cut: false, removedMm3: [0.5, 0.25]};
  const block = solidBlock("cube", kPitBlock, 9, pit(), more);
  expect(toSolidBlock(through("/palpate/solid_block", block))).toEqual({
    ...{scene: "cube", objectIndex: 2, block: kPitBlock, change: 9, serverRun: "1", cut: false},
    ...{originM: [-0.0336, -0.0336, -0.0336], spacingM: 0.0021, blocks: [4, 4, 4], surface: pit()},
    removedMm3: [0.5, 0.25],
  });
});

test("fields that a newer server adds are no obstacle", () => {
  const idl = readFileSync(new URL("../../../idl/teaching.idl", import.meta.url), "utf8").replace(
    "string<64> scene;\n    double period_s;",
    "string<64> scene;\n    string<8> colour;\n    double period_s;",
  );
  expect(idl).toContain("colour");
  const writer = new MessageWriter("palpate::LoopStatistics", parseIDL(idl));
  const bytes = writer.writeMessage({...loopStatistics("hand", "cube"), colour: "red"});
  const newer = {...channel("/palpate/loop_statistics"), schema: idl};
  expect(toLoopStatistics(makeDecoder(newer)!(bytes))).toMatchObject({
    station: "hand",
    rateHz: 1000,
  });
});

test("fields that an older server lacks are zero or empty", () => {
  expect(toToolState({station: "hand"})).toMatchObject({
    contacts: 0,
    points: [],
    forceN: [0, 0, 0],
  });
  expect(toToolState(undefined).graphic).toEqual({p: [0, 0, 0], q: [1, 0, 0, 0]});
});

test("a phase of the mouse that the page does not know is none", () => {
  expect(toMouseState({phase: "refused", reason: "taken"})).toMatchObject({
    phase: "refused",
    reason: "taken",
  });
  expect(toMouseState({phase: "sleeping"}).phase).toBe("");
});

test("an encoding that the page cannot read is no channel for it", () => {
  expect(makeDecoder({...channel("/palpate/tool_state"), encoding: "protobuf"})).toBeUndefined();
});
