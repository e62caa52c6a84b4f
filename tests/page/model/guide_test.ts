import {describe, expect, it} from "vitest";

import {Guide} from "../../../client/page/src/model/guide";

// 100 mm along x in 2 s, then a quarter turn about x.
const kKeys = [
  [0, 0, 0, 0, 1, 0, 0, 0],
  [2, 0.1, 0, 0, 1, 0, 0, 0],
  [3, 0.1, 0, 0, Math.SQRT1_2, Math.SQRT1_2, 0, 0],
];

describe("Guide", () => {
  it("is where the expert's hand is: minimum jerk between keys, held at the ends", () => {
    const guide = new Guide(kKeys);
    expect(guide.poseAt(-1).p[0]).toBe(0);
    expect(guide.poseAt(0.5).p[0]).toBeCloseTo(0.1 * (10 / 64 - 15 / 256 + 6 / 1024), 12);
    expect(guide.poseAt(1).p[0]).toBeCloseTo(0.05, 12);
    expect(guide.poseAt(2.5).q[1]).toBeCloseTo(Math.sin(Math.PI / 8), 9);
    expect(guide.poseAt(9).q[0]).toBeCloseTo(Math.SQRT1_2, 12);
  });

  it("goes at the expert's pace beside a hand that follows, and waits for one that does not", () => {
    const guide = new Guide(kKeys);
    let aim = guide.lead(10, [0, 0, 0]);
    for (let i = 1; i <= 100; ++i) aim = guide.lead(10 + 0.01 * i, aim.p);
    expect(aim.p[0]).toBeCloseTo(0.05, 6);
    for (let i = 1; i <= 100; ++i) guide.lead(11 + 0.01 * i, [0.02, 0, 0]);
    expect(guide.lead(12.1, undefined).p[0]).toBeCloseTo(0.05, 6);
    expect(guide.isOver).toBe(false);
    for (let i = 1; i <= 300; ++i) aim = guide.lead(12.1 + 0.01 * i, aim.p);
    expect(guide.isOver).toBe(true);
  });
});
