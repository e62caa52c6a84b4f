import {expect, test} from "vitest";

import {Pedal} from "@page/mouse/pedal";

test("a bur turns while its pedal is held, and a tap lets it turn until the next", () => {
  const changes: boolean[] = [];
  const pedal: Pedal = new Pedal(() => changes.push(pedal.turns));
  pedal.down(0);
  pedal.down(200); // a key repeats
  expect(pedal.turns).toBe(true);
  pedal.up(1000);
  expect(pedal.turns).toBe(false);
  pedal.down(2000);
  pedal.up(2100);
  expect(pedal.turns).toBe(true);
  pedal.down(3000);
  pedal.up(3100);
  expect(pedal.turns).toBe(false);
  expect(changes).toEqual([true, false, true, false]);
});

test("what ends the hold ends the turning, and the release that follows says nothing", () => {
  const pedal = new Pedal(() => {});
  pedal.down(0);
  pedal.off();
  expect(pedal.turns).toBe(false);
  pedal.up(100);
  expect(pedal.turns).toBe(false);
});
