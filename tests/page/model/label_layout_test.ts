import {expect, test} from "vitest";

import {layOut, type Point} from "@page/model/label_layout";

const kLabel = {width: 30, height: 20};
const kRoom = {width: 800, height: 600};

const overlap = (a: Point, b: Point): number =>
  Math.min(kLabel.width - Math.abs(a.x - b.x), kLabel.height - Math.abs(a.y - b.y));

test("labels that are wanted in one place are put beside each other", () => {
  const wanted = Array.from({length: 14}, (_, i) => ({x: 400 + 9 * i, y: 300 + (i % 3)}));
  const places = layOut(wanted, kLabel, [], kRoom);
  places.forEach((a, i) =>
    places.slice(0, i).forEach((b) => expect(overlap(a, b)).toBeLessThan(1)),
  );
});

test("labels keep clear of the tool", () => {
  const tool = Array.from({length: 10}, (_, i) => ({x: 300 + 20 * i, y: 280 + 5 * i, radius: 15}));
  const wanted = Array.from({length: 5}, (_, i) => ({x: 300 + 45 * i, y: 285 + 11 * i}));
  for (const {x, y} of layOut(wanted, kLabel, tool, kRoom)) {
    for (const circle of tool) {
      const off = Math.hypot(
        Math.max(0, Math.abs(x - circle.x) - kLabel.width / 2),
        Math.max(0, Math.abs(y - circle.y) - kLabel.height / 2),
      );
      expect(off).toBeGreaterThan(circle.radius - 1);
    }
  }
});

test("a label that nothing disturbs stays where it is wanted, within the picture", () => {
  expect(layOut([{x: 100, y: 50}], kLabel, [], kRoom)).toEqual([{x: 100, y: 50}]);
  expect(layOut([{x: -40, y: 900}], kLabel, [], kRoom)).toEqual([{x: 15, y: 590}]);
});
