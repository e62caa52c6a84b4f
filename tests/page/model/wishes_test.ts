import {expect, test} from "vitest";

import {type Wish, Wishes} from "@page/model/wishes";
import type {ReplayState} from "@page/protocol/messages";

import {replayState} from "../support/replay_state";

interface Sent extends Wish {
  readonly tag: number;
  readonly replay: string;
}
const answer = (request: string, refusal = ""): ReplayState => replayState(0, {request, refusal});

function rig() {
  const sent: Sent[] = [];
  const refused: string[] = [];
  const link = {isOpen: true};
  const wishes = new Wishes(
    (message) => {
      if (link.isOpen) sent.push(message as Sent);
      return link.isOpen;
    },
    (wish, reason) => refused.push(`${wish.wish}: ${reason}`),
  );
  return {wishes, sent, refused, link, ask: wishes.ask.bind(wishes, "ab")};
}

test("a wish goes out with its replay and a number of its own", () => {
  const {sent, ask} = rig();
  ask({wish: "play"}, 1);
  ask({wish: "rate", value: 0.5}, 1);
  expect(sent).toEqual([
    {replay: "ab", tag: 1, wish: "play"},
    {replay: "ab", tag: 2, wish: "rate", value: 0.5},
  ]);
});

test("the next bookmark waits for the replay's answer to the one before, and none is lost", () => {
  const {wishes, sent, ask} = rig();
  for (const text of ["a", "b", "c"]) ask({wish: "add_bookmark", value: 1, text}, 1);
  expect(sent.map(({text}) => text)).toEqual(["a"]);
  wishes.answered({tag: 1, request: "f1", refusal: ""});
  wishes.flush("ab", 1.1);
  wishes.told(answer("77")); // another viewer's
  wishes.flush("ab", 1.2);
  expect(sent.length).toBe(1);
  wishes.told(answer("f1"));
  wishes.flush("ab", 1.3);
  expect(sent.map(({text}) => text)).toEqual(["a", "b"]);
  // The replay may be quicker than the gateway.
  wishes.told(answer("f2"));
  wishes.answered({tag: 2, request: "f2", refusal: ""});
  wishes.flush("ab", 1.4);
  expect(sent.map(({text}) => text)).toEqual(["a", "b", "c"]);
});

test("of rates that wait the last counts", () => {
  const {wishes, sent, ask} = rig();
  for (const value of [0.5, 1, 2, 4]) ask({wish: "rate", value}, 1);
  expect(wishes.rate).toBe(4);
  wishes.answered({tag: 1, request: "f1", refusal: ""});
  wishes.told(answer("f1"));
  wishes.flush("ab", 1.1);
  expect(sent.map(({value}) => value)).toEqual([0.5, 4]);
  wishes.answered({tag: 2, request: "f2", refusal: ""});
  wishes.told(answer("f2"));
  expect(wishes.rate).toBeUndefined();
});

test("a bar that is dragged sends five times a second, and where it was let go of always", () => {
  const {wishes, sent, ask} = rig();
  for (let i = 0; i <= 100; ++i) {
    ask({wish: "seek", value: i}, 10 + i / 100);
    wishes.flush("ab", 10 + i / 100);
  }
  expect(sent.length).toBeLessThanOrEqual(6);
  expect(wishes.soughtS).toBe(100);
  wishes.flush("ab", 11.3);
  expect(sent.at(-1)?.value).toBe(100);
  const count = sent.length;
  wishes.flush("ab", 12);
  expect(sent.length).toBe(count);
  // It is there once the replay says so of the last.
  wishes.answered({tag: sent.at(-1)!.tag, request: "f9", refusal: ""});
  expect(wishes.soughtS).toBe(100);
  wishes.told(answer("f9"));
  expect(wishes.soughtS).toBeUndefined();
});

test("play and pause take turns, so that the later one counts", () => {
  const {wishes, sent, ask} = rig();
  ask({wish: "play"}, 1);
  ask({wish: "pause"}, 1);
  expect(wishes.playing).toBe(false);
  expect(sent.map(({wish}) => wish)).toEqual(["play"]);
  wishes.answered({tag: 1, request: "f1", refusal: ""});
  wishes.told(answer("f1"));
  wishes.flush("ab", 1);
  expect(sent.map(({wish}) => wish)).toEqual(["play", "pause"]);
});

test("an answer that does not come is not waited for for ever", () => {
  const {wishes, sent, ask} = rig();
  ask({wish: "drop_bookmark", value: 1}, 1);
  ask({wish: "drop_bookmark", value: 2}, 1);
  wishes.flush("ab", 2.9);
  expect(sent.length).toBe(1);
  wishes.flush("ab", 3.1);
  expect(sent.map(({value}) => value)).toEqual([1, 2]);
});

test("a refusal is told once, whoever refuses", () => {
  const {wishes, refused, link, ask} = rig();
  ask({wish: "add_bookmark", value: 1, text: "a"}, 1);
  wishes.answered({tag: 1, request: "f1", refusal: ""});
  wishes.told(answer("f1", "the disk is full"));
  wishes.told(answer("f1", "the disk is full"));
  ask({wish: "seek", value: 1}, 2);
  wishes.answered({tag: 2, request: "f2", refusal: "that replay has ended"});
  link.isOpen = false;
  ask({wish: "play"}, 3);
  expect(refused).toEqual([
    "add_bookmark: the disk is full",
    "seek: that replay has ended",
    "play: the link to the gateway is lost",
  ]);
  expect(wishes.soughtS).toBeUndefined();
  expect(wishes.playing).toBeUndefined();
});

test("another replay is asked for nothing that was wished of this one", () => {
  const {wishes, sent, ask} = rig();
  ask({wish: "rate", value: 2}, 1);
  ask({wish: "rate", value: 4}, 1);
  wishes.clear();
  wishes.flush("cd", 9);
  expect(sent.length).toBe(1);
  expect(wishes.rate).toBeUndefined();
});
