import {readFileSync} from "node:fs";

import {describe, expect, test} from "vitest";

import {
  clock,
  deviceLines,
  faultWords,
  fitBytes,
  stationNote,
  spokenTime,
  statisticsLines,
} from "@page/model/words";
import {
  kLimiterStages,
  toLoopStatistics,
  toSessionState,
  toStationStatistics,
} from "@page/protocol/messages";

import {stationStatistics} from "../support/fake_gateway";

/// A source of the project: the words are held to what travels.
const source = (path: string): string =>
  readFileSync(new URL(`../../../${path}`, import.meta.url), "utf8");

describe("the loop's lines", () => {
  const lines = (more: object) =>
    Object.fromEntries(
      statisticsLines(toLoopStatistics({rate_hz: 1000, steps: 1000, step_us_p50: 9, ...more})).map(
        (line) => [line.label, line],
      ),
    );

  test("praise no rate at which a load no longer holds", () => {
    const tooSlow = {remark: "should be a thousand", tone: "bad"};
    expect(lines({rate_hz: 953}).Rate).toMatchObject({value: "953 / s", ...tooSlow});
    expect(lines({rate_hz: 1060}).Rate).toMatchObject(tooSlow);
    expect(lines({rate_hz: 995}).Rate).toMatchObject({remark: "as it should be", tone: "good"});
  });

  test("name what is wrong", () => {
    const bad = lines({
      rate_hz: 700,
      late: 40n,
      lost: 1n,
      rejected_speed: 3n,
      faults: 2,
      faulted_steps: 5n,
    });
    expect(bad.Rate?.tone).toBe("bad");
    expect(bad.Late).toMatchObject({value: "40 poses", tone: "bad"});
    expect(bad.Lost).toMatchObject({value: "1 pose", tone: "bad"});
    expect(bad.Refused?.value).toBe("3 poses");
    expect(bad.Faults?.remark).toBe("the hand was quicker than the tool, which followed");
  });
});

test("every fault bit that there is has its words, and no other", () => {
  const bits = [...source("common/step_fault.h").matchAll(/kFault\w+ = 1u << (\d+)/g)];
  const known = new Set(bits.map(([, bit]) => Number(bit)));
  expect(known.size).toBeGreaterThan(5);
  for (let bit = 0; bit < 31; ++bit) {
    expect(faultWords(1 << bit).length, `bit ${bit}`).toBe(known.has(bit) ? 1 : 0);
  }
  expect(faultWords(0)).toEqual([]);
});

test("phases are those of the IDL, in its order", () => {
  const phases = /enum SessionPhase \{([^}]*)\}/.exec(source("idl/session.idl"))![1]!;
  const names = [...phases.matchAll(/SESSION_(\w+)/g)].map(([, name]) => name!.toLowerCase());
  expect(names.length).toBe(6);
  names.forEach((name, phase) => expect(toSessionState({phase}).phase).toBe(name));
});

describe("the arm's lines", () => {
  const lines = (more: object) =>
    Object.fromEntries(
      deviceLines(toStationStatistics(stationStatistics("hand", more))).map((line) => [
        line.label,
        line,
      ]),
    );

  test("name the stages that act, the busiest first", () => {
    const late = lines({faded: 400n, slewed: 5n, braked: 20n, lost: 3n, applied_force_N_max: 1.5});
    expect(late["Held back"]).toMatchObject({
      value: "40 %",
      remark:
        "of the time: force, while replies are late or missing; energy that delay would add (2 %); " +
        "jumps of the force (< 1 %)",
      tone: "bad",
    });
    expect(late.Strongest?.remark).toBe("of 2.00 N computed");
    expect(late.Silence).toMatchObject({
      remark: "the longest without a reply; 3 lost",
      tone: "bad",
    });
    expect(lines({warm: 10n, warmth: 0.8}).Motors).toMatchObject({value: "80 %", tone: "bad"});
    expect(lines({energy_J_min: -0.004}).Energy).toMatchObject({value: "4.0 mJ", tone: "bad"});
    expect(lines({replies: 0n, silence_s_max: 12.3, faded: 1000n}).Silence).toMatchObject({
      value: "12.3 s",
      remark: "no answer from the server: no force",
    });
  });

  test("have words for each stage that the station counts", () => {
    const idl = /struct StationStatistics \{([^}]*)\}/.exec(source("idl/teaching.idl"))![1]!;
    const [, stages] = /of the limiter did.*\n([\s\S]*?)\n\s*double wanted/.exec(idl)!;
    const names = [...stages!.matchAll(/unsigned long long (\w+);/g)].map(([, name]) => name);
    expect(names.filter((name) => name !== "fades")).toEqual([...kLimiterStages]);
    for (const stage of kLimiterStages) {
      expect(lines({[stage]: 1000n})["Held back"]?.value).toBe("100 %");
    }
  });

  test("say what is wrong with the device", () => {
    const bit = (name: string): number =>
      1 << Number(new RegExp(`${name} = 1u << (\\d+)`).exec(source("devices/device.h"))![1]);
    expect(lines({device_status: bit("kDeviceFault")}).Device).toMatchObject({
      value: "fault: no force",
      tone: "bad",
    });
    expect(lines({device_status: bit("kDeviceCalibrating")}).Device?.value).toBe("calibrates");
    const blind = lines({device_status: bit("kDeviceForcesIgnored")});
    expect(blind.Device?.value).toBe("renders no force");
    expect(Object.keys(blind)).toEqual(["Device", "Silence"]);
  });
});

test("who feels a session's forces, or sees them, is told what keeps them from the hand", () => {
  const session = (more: object) =>
    toSessionState({station: "anna", phase: 2, scene: "cube", tool: "ball", ...more});
  expect(stationNote(undefined, true)).toBe("");
  expect(stationNote(session({}), true)).toBe("");
  expect(stationNote(session({muted: true}), true)).toBe(
    "You are muted by a teacher: no force reaches your hand.",
  );
  expect(stationNote(session({muted: true}), false)).toBe(
    "anna is muted by a teacher: no force reaches that hand.",
  );
  expect(stationNote(session({muted: true, phase: 4}), true)).toBe(""); // it has left
  expect(stationNote(session({phase: 5}), true)).toMatch(/waiting for a teacher to admit you/);
  expect(stationNote(session({phase: 1, start_depth_m: 0.0032}), true)).toMatch(/3.2 mm inside/);
});

test("times of a recording are written as players write them, and said in words", () => {
  expect([0, 5.99, 65, 600, 3723, -1].map(clock)).toEqual([
    "0:00",
    "0:05",
    "1:05",
    "10:00",
    "1:02:03",
    "0:00",
  ]);
  expect(spokenTime(1)).toBe("1 second");
  expect(spokenTime(125.4)).toBe("2 minutes 5 seconds");
});

test("a text is cut by its bytes, and between letters", () => {
  expect(fitBytes("slip", 4)).toBe("slip");
  expect(fitBytes("slips", 4)).toBe("slip");
  expect(fitBytes("éé", 3)).toBe("é");
  expect(fitBytes("a🦷b", 4)).toBe("a");
  expect(fitBytes("a🦷b", 5)).toBe("a🦷");
});
