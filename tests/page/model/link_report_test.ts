import {expect, test} from "vitest";

import {type LinkFacts, type LinkReport, linkReport, Pulse} from "@page/model/link_report";

const kFine: LinkFacts = {
  link: "open",
  wasOpen: true,
  nowS: 100,
  openedS: 10,
  lastStateS: 99.9,
  sessions: 1,
  scenes: 1,
  refusal: "none",
  serverLives: true,
  compiling: undefined,
  mayTake: true,
  takes: false,
  draws: true,
  replay: "none",
  recording: "lesson.mcap",
  replaySilenceS: 0.1,
  busyS: -Infinity,
};

const kQuiet: Partial<LinkFacts> = {lastStateS: 90};
const kIdle: Partial<LinkFacts> = {...kQuiet, sessions: 0};
const kSilent: Partial<LinkFacts> = {lastStateS: 50};
const kFirstTry: Partial<LinkFacts> = {link: "lost", wasOpen: false};
const kCompiling = {scene: "bunny", stage: "touching balls", done: 0.438};
const kCompiles = /compiles bunny for the first time: 43 %, touching balls/;

test.each<[string, Partial<LinkFacts>, LinkReport["tone"], RegExp | undefined]>([
  ["data flow", {}, "none", undefined],
  ["a lost link is said at once", {link: "lost"}, "alarm", /lost/],
  ["also while it is tried again", {link: "connecting"}, "alarm", /lost/],
  ["and is told from a first try", {...kFirstTry, link: "connecting"}, "info", undefined],
  ["that nobody answers", kFirstTry, "alarm", /does not answer/],
  ["silence counts from 1.5 s on", {lastStateS: 98.6}, "none", undefined],
  ["and is somebody's", {lastStateS: 98.4}, "alarm", /gateway answers/],
  ["or nobody's", {lastStateS: 98.4, sessions: 0}, "info", /Nobody moves a tool/],
  ["no server", {...kIdle, lastStateS: -Infinity, scenes: 0}, "info", /no server has announced/],
  [
    "that has not gone",
    {...kIdle, scenes: 0, serverLives: false},
    "info",
    /no server has announced/,
  ],
  ["one that has gone", {...kSilent, serverLives: false}, "alarm", /No server is there/],
  ["and the next compiles", {serverLives: false, compiling: kCompiling}, "info", kCompiles],
  ["one compiles its first scene", {scenes: 0, compiling: kCompiling}, "info", kCompiles],
  ["another does, which is no news here", {compiling: kCompiling}, "none", undefined],
  ["a tool is offered", {...kIdle, lastStateS: -Infinity}, "info", /Take the tool with the mouse/],
  ["not to who takes one", {...kIdle, lastStateS: -Infinity, takes: true}, "none", undefined],
  [
    "nor to who may not",
    {...kIdle, mayTake: false},
    "info",
    /^Nobody moves a tool. Start a station.$/,
  ],
  ["a gateway is full", {link: "lost", refusal: "full"}, "alarm", /as many viewers as it allows/],
  ["from the first try on", {...kFirstTry, refusal: "full"}, "alarm", /as many viewers/],
  ["or turns this page away", {link: "lost", refusal: "this page"}, "alarm", /refuses this page/],
  ["at first, too", {...kFirstTry, refusal: "this page"}, "alarm", /refuses this page/],
  ["or wants a token", {link: "lost", refusal: "token"}, "alarm", /link that you were given/],
  ["at first, too", {...kFirstTry, refusal: "token"}, "alarm", /link that you were given/],
  ["there is no picture", {draws: false}, "info", /no WebGL/],
  ["which is no alarm's match", {...kQuiet, draws: false}, "alarm", /No data/],
  ["nor a lost link's", {draws: false, link: "lost"}, "alarm", /lost/],
  ["a link that has just been opened", {openedS: 99, lastStateS: 20}, "none", undefined],
  ["the page draws slowly", {...kQuiet, busyS: 99.9}, "info", /This browser draws too slowly/],
  ["and has heard all by now", {...kQuiet, busyS: 98}, "alarm", /No data/],
  ["or hears enough", {busyS: 99.9}, "none", undefined],
  ["or nothing any more", {...kQuiet, busyS: 99.9, link: "lost"}, "alarm", /lost/],
  ["a replay stands still", {...kSilent, replay: "paused"}, "none", undefined],
  ["or holds a moment without motion", {...kSilent, replay: "playing"}, "none", undefined],
  [
    "it has ended",
    {...kSilent, replay: "ended"},
    "info",
    /^The replay of lesson\.mcap has ended\./,
  ],
  [
    "it has fallen silent",
    {...kSilent, replay: "silent", replaySilenceS: 4.9},
    "alarm",
    /lesson\.mcap has been silent for 4 s: its program has stop/,
  ],
  ["what is nearer goes first", {replay: "silent", link: "lost"}, "alarm", /link to the gateway/],
])("%s", (_what, facts, tone, text) => {
  const report = linkReport({...kFine, ...facts});
  expect(report.tone).toBe(tone);
  if (text) expect(report.text).toMatch(text);
});

test("a timer that comes late tells that the page could not run, unless nobody sees it", () => {
  const pulse = new Pulse();
  pulse.beat(10, true);
  pulse.beat(10.1, true);
  expect(pulse.busyS).toBe(-Infinity);
  pulse.beat(12.5, true);
  expect(pulse.busyS).toBe(12.5);
  pulse.beat(13.5, false);
  pulse.beat(14.5, false);
  pulse.beat(16, true);
  expect(pulse.busyS).toBe(12.5);
});
