import {expect, test} from "vitest";

import {Ladder} from "@page/model/ladder";

/// Pictures that take so long each, for so long.  @return the rungs that were stood on, in order
function draw(ladder: Ladder, ms: number | ((rung: number) => number), seconds: number): number[] {
  const stood = [ladder.rung];
  for (let spent = 0; spent < 1000 * seconds; ) {
    const took = typeof ms === "number" ? ms : ms(ladder.rung);
    spent += took;
    if (ladder.took(took)) stood.push(ladder.rung);
  }
  return stood;
}

test.each([
  ["a machine that draws fast stays on top", 8, [0]],
  ["so does one whose screen shows sixty a second", 1000 / 60, [0]],
  ["thirty are enough, also where a screen shows no more", 1000 / 30, [0]],
  ["a slow machine descends, rung by rung where it is a little too slow", 45, [0, 1, 2, 3]],
  ["one that is much too slow is not made to try every rung", 300, [0, 3]],
] as const)("%s", (_what, ms, stood) => expect(draw(new Ladder(4), ms, 60)).toEqual(stood));

test("a picture that is late now and then moves nothing", () => {
  const ladder = new Ladder(4);
  for (let i = 0; i < 1000; i++) ladder.took(i % 4 === 0 ? 150 : 16);
  expect(ladder.rung).toBe(0);
});

test("the first pictures of a rung do not count against it", () => {
  const ladder = new Ladder(4);
  for (let i = 0; i < 2; i++) ladder.took(5000);
  expect(draw(ladder, 16, 10)).toEqual([0]);
});

test("who has time to spare climbs, and holds what is fast enough there", () => {
  const ladder = new Ladder(4, 3);
  const cost = (rung: number): number => [60, 30, 20, 12][rung]!;
  expect(draw(ladder, cost, 30)).toEqual([3, 2, 1]);
});

test("while a page is hidden no time is won to climb", () => {
  const ladder = new Ladder(2, 1);
  draw(ladder, 12, 1);
  ladder.took(60_000);
  draw(ladder, 12, 1);
  expect(ladder.rung).toBe(1);
  draw(ladder, 12, 2);
  expect(ladder.rung).toBe(0);
});

test("a rung that was too much is tried again more and more seldom", () => {
  const ladder = new Ladder(2, 1);
  const cost = (rung: number): number => [50, 12][rung]!;
  const tries = (seconds: number): number =>
    draw(ladder, cost, seconds).filter((rung) => rung === 0).length;
  expect(tries(10)).toBe(2);
  expect(tries(60)).toBe(3);
  expect(tries(600)).toBeLessThanOrEqual(11);
});

test("another scene is drawn as well as the first one was, to begin with", () => {
  const ladder = new Ladder(4);
  draw(ladder, 300, 5);
  ladder.restart();
  expect(ladder.rung).toBe(0);
});
