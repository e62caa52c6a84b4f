import {describe, expect, test} from "vitest";

import {faultWords, figure, sessionWords, statisticsLines, statusSentence} from "@page/model/words";
import {toLoopStatistics, toSessionState, toToolState} from "@page/protocol/messages";

describe("the sentence for who does not see", () => {
  test("says that nothing moves, that the tool is free, and how hard it presses", () => {
    expect(statusSentence(undefined)).toBe("No tool is moving.");
    expect(statusSentence(toToolState({}))).toBe("The tool is free.");
    const pressed = toToolState({
      contacts: 2,
      force_N: [0, 1.2, 0],
      haptic_position_m: [0, -0.0012, 0],
    });
    expect(statusSentence(pressed)).toBe(
      "Contact, 1.2 newtons, hand 1.2 millimetres past the surface.",
    );
  });
});

test("figures have no more digits than a person reads", () => {
  expect([0, 0.123, 12.34, 123.4, -0.5, NaN].map((value) => figure(value))).toEqual([
    "0.00",
    "0.12",
    "12.3",
    "123",
    "-0.50",
    "–",
  ]);
});

describe("the loop's lines", () => {
  const lines = (more: object) =>
    Object.fromEntries(
      statisticsLines(toLoopStatistics({rate_hz: 1000, steps: 1000, step_us_p50: 9, ...more})).map(
        (line) => [line.label, line],
      ),
    );

  test("praise a loop that holds", () => {
    const good = lines({});
    expect(good.Rate).toMatchObject({value: "1000 / s", tone: "good"});
    expect(good.Late).toMatchObject({value: "0 poses", tone: "good"});
    expect(good.Faults?.value).toBe("none");
    expect(good.Refused).toBeUndefined();
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

test("every fault bit has its words", () => {
  expect(faultWords(0)).toEqual([]);
  expect(faultWords(0b111_0001_1111).length).toBe(8);
});

test("a session's words say who has what, or why not", () => {
  const session = (phase: number, reason = "") =>
    sessionWords(toSessionState({station: "hand", phase, scene: "cube", tool: "ball", reason}));
  expect(session(2)).toBe("drives the ball of cube");
  expect(session(3, "it is driven by 'other'")).toContain("it is driven by 'other'");
  expect(session(4)).toContain("has left");
  const inside = toSessionState({phase: 1, scene: "cube", tool: "ball", start_depth_m: 0.0032});
  expect(sessionWords(inside)).toBe(
    "starts with the ball of cube 3.2 mm inside an object: no force until it is out",
  );
});
