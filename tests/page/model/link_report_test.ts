import {expect, test} from "vitest";

import {type LinkFacts, linkReport} from "@page/model/link_report";

const kFine: LinkFacts = {
  link: "open",
  wasOpen: true,
  nowS: 100,
  openedS: 10,
  lastStateS: 99.9,
  sessions: 1,
  scenes: 1,
};

test("nothing is said while data flow", () => {
  expect(linkReport(kFine).tone).toBe("none");
});

test("a lost link is said at once, and told from a first try", () => {
  expect(linkReport({...kFine, link: "lost"})).toMatchObject({
    tone: "alarm",
    text: expect.stringMatching(/lost/),
  });
  expect(linkReport({...kFine, link: "connecting"}).tone).toBe("alarm");
  expect(linkReport({...kFine, link: "connecting", wasOpen: false}).tone).toBe("info");
  expect(linkReport({...kFine, link: "lost", wasOpen: false}).text).toMatch(/does not answer/);
});

test("silence is said after one and a half seconds, with whose it is", () => {
  expect(linkReport({...kFine, lastStateS: 98.6}).tone).toBe("none");
  expect(linkReport({...kFine, lastStateS: 98.4})).toMatchObject({
    tone: "alarm",
    text: expect.stringMatching(/gateway is there/),
  });
  expect(linkReport({...kFine, lastStateS: 98.4, sessions: 0})).toMatchObject({
    tone: "info",
    text: expect.stringMatching(/No station is moving/),
  });
  expect(linkReport({...kFine, lastStateS: -Infinity, sessions: 0, scenes: 0}).text).toMatch(
    /no server/,
  );
});

test("a link that has just been opened is given time", () => {
  expect(linkReport({...kFine, openedS: 99, lastStateS: 20}).tone).toBe("none");
});
