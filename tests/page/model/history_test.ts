import {expect, test} from "vitest";

import {History} from "@page/model/history";

test("a history gives its last seconds, counted from now", () => {
  const history = new History(2, 10);
  for (let i = 0; i <= 300; i++) history.push(i / 10, i, -i);
  const [times, first] = history.series(0, 30);
  expect(times.length).toBe(101);
  expect(times[0]).toBeCloseTo(-10, 9);
  expect(times.at(-1)).toBeCloseTo(0, 9);
  expect(first.at(-1)).toBe(300);
  expect(history.series(1, 30)[1][0]).toBe(-200);
});

test("a history is empty once all of it is too old, and takes no step back in time", () => {
  const history = new History(1, 5);
  history.push(1, 1);
  history.push(0.5, 2);
  expect(history.series(0, 1)).toEqual([[0], [1]]);
  expect(history.series(0, 100)).toEqual([[], []]);
  history.clear(); // and begins anew, at any time
  expect(history.series(0, 1)).toEqual([[], []]);
  history.push(0.5, 2);
  expect(history.series(0, 1.5)).toEqual([[-1], [2]]);
});
