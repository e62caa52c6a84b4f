import {expect, test} from "vitest";

import {Announcer} from "@page/ui/announcer";

test("a sentence is said every few seconds at most, and never twice in a row", () => {
  const said: string[] = [];
  const announcer = new Announcer((sentence) => said.push(sentence));
  announcer.offer("free", 0);
  announcer.offer("contact 1", 1000);
  announcer.offer("contact 2", 3900);
  announcer.offer("contact 3", 4100);
  announcer.offer("contact 3", 60_000);
  expect(said).toEqual(["free", "contact 3"]);
});
