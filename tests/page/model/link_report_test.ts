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

const expectReport = (facts: LinkFacts, tone: LinkReport["tone"], text: RegExp): void =>
  expect(linkReport(facts)).toMatchObject({tone, text: expect.stringMatching(text)});

test("nothing is said while data flow", () => {
  expect(linkReport(kFine).tone).toBe("none");
});

test("a lost link is said at once, and told from a first try", () => {
  expectReport({...kFine, link: "lost"}, "alarm", /lost/);
  expect(linkReport({...kFine, link: "connecting"}).tone).toBe("alarm");
  expect(linkReport({...kFine, link: "connecting", wasOpen: false}).tone).toBe("info");
  expect(linkReport({...kFine, link: "lost", wasOpen: false}).text).toMatch(/does not answer/);
});

test("silence is said after one and a half seconds, with whose it is", () => {
  expect(linkReport({...kFine, lastStateS: 98.6}).tone).toBe("none");
  expectReport({...kFine, lastStateS: 98.4}, "alarm", /gateway is there/);
  expectReport({...kFine, lastStateS: 98.4, sessions: 0}, "info", /No station is moving/);
  expect(linkReport({...kFine, lastStateS: -Infinity, sessions: 0, scenes: 0}).text).toMatch(
    /no server/,
  );
});

test("a server that has gone is not one that is silent, and one that compiles is on its way", () => {
  const quiet: LinkFacts = {...kFine, lastStateS: 50};
  expectReport({...quiet, serverLives: false}, "alarm", /No server is there/);
  const compiling = {scene: "bunny", stage: "touching balls", done: 0.438};
  for (const facts of [
    {...quiet, serverLives: false, compiling},
    {...quiet, scenes: 0, compiling},
  ]) {
    expectReport(facts, "info", /compiles bunny for the first time: 43 %, touching balls/);
  }
  // What another server is about to serve is no news to who sees this one.
  expect(linkReport({...kFine, compiling}).tone).toBe("none");
  expect(linkReport({...quiet, sessions: 0, scenes: 0, serverLives: false}).text).toMatch(
    /no server has told/,
  );
});

test("who takes a tool is not told to take one", () => {
  const quiet: LinkFacts = {...kFine, lastStateS: -Infinity, sessions: 0};
  expect(linkReport(quiet).text).toMatch(/take the tool/);
  expect(linkReport({...quiet, takes: true}).tone).toBe("none");
});

test("a gateway that turns this page away is not one that does not answer", () => {
  for (const wasOpen of [true, false]) {
    const lost: LinkFacts = {...kFine, link: "lost", wasOpen};
    expect(linkReport({...lost, refusal: "full"}).text).toMatch(/as many viewers as it takes/);
    expect(linkReport({...lost, refusal: "this page"}).text).toMatch(/does not let this page/);
    expect(linkReport({...lost, refusal: "this page"}).tone).toBe("alarm");
    expect(linkReport({...lost, refusal: "token"}).text).toMatch(/link that you were given/);
  }
});

test("what a page cannot do is not offered", () => {
  const idle: LinkFacts = {...kFine, lastStateS: 90, sessions: 0};
  expect(linkReport(idle).text).toMatch(/mouse/);
  expect(linkReport({...idle, mayTake: false}).text).toBe("No station is moving. Start one.");
});

test("a page without a picture says so, but not before an alarm", () => {
  expectReport({...kFine, draws: false}, "info", /no WebGL/);
  expect(linkReport({...kFine, draws: false, lastStateS: 90}).tone).toBe("alarm");
  expect(linkReport({...kFine, draws: false, link: "lost"}).tone).toBe("alarm");
});

test("a link that has just been opened is given time", () => {
  expect(linkReport({...kFine, openedS: 99, lastStateS: 20}).tone).toBe("none");
});

test("a browser that draws slowly does not blame the server", () => {
  const quiet: LinkFacts = {...kFine, lastStateS: 95};
  expectReport({...quiet, busyS: 99.9}, "info", /This browser draws slowly/);
  // What came while the page drew has been heard by now: the silence is the server's.
  expect(linkReport({...quiet, busyS: 98}).tone).toBe("alarm");
  expect(linkReport({...kFine, busyS: 99.9}).tone).toBe("none");
  expect(linkReport({...quiet, busyS: 99.9, link: "lost"}).tone).toBe("alarm");
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

test("a replay may stand still, and says when it is over", () => {
  const paused: LinkFacts = {...kFine, lastStateS: 50, replay: "paused"};
  expect(linkReport(paused).tone).toBe("none");
  expect(linkReport({...paused, replay: "playing"}).tone).toBe("none");
  expect(linkReport({...paused, replay: "ended"})).toEqual({
    tone: "info",
    text: "The replay of lesson.mcap has ended. What you see is the last of it.",
  });
  expectReport(
    {...paused, replay: "silent", replaySilenceS: 4.9},
    "alarm",
    /lesson\.mcap has not been heard of for 4 s: its program has stop/,
  );
  // What is nearer goes first.
  expect(linkReport({...paused, replay: "silent", link: "lost"}).text).toMatch(/link to the gate/);
});
