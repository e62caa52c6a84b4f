import {expect, test} from "vitest";

import {clientMessage, parseBinary, parseText} from "@page/protocol/foxglove";

test("a data message is taken apart as the protocol lays it out", () => {
  // opcode 1, subscription 7, 1.5 s in nanoseconds, payload
  const bytes = Uint8Array.from([1, 7, 0, 0, 0, 0, 0x2f, 0x68, 0x59, 0, 0, 0, 0, 0xaa, 0xbb]);
  const message = parseBinary(bytes.buffer)!;
  expect(message.subscription).toBe(7);
  expect(message.stampS).toBeCloseTo(1.5, 9);
  expect([...message.payload]).toEqual([0xaa, 0xbb]);
});

test("other and cut binary messages are none", () => {
  expect(
    parseBinary(Uint8Array.from([2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]).buffer),
  ).toBeUndefined();
  expect(parseBinary(Uint8Array.from([1, 2, 3]).buffer)).toBeUndefined();
  expect(parseBinary(new ArrayBuffer(0))).toBeUndefined();
});

test("what the page sends begins with opcode and channel", () => {
  const bytes = clientMessage(258, {op: "release"});
  expect([...bytes.subarray(0, 5)]).toEqual([1, 2, 1, 0, 0]);
  expect(JSON.parse(new TextDecoder().decode(bytes.subarray(5)))).toEqual({op: "release"});
});

test("channels are read with what they have, and what is no channel is left out", () => {
  const message = parseText(
    JSON.stringify({
      op: "advertise",
      channels: [{id: 1, topic: "/a", encoding: "cdr"}, "no", {topic: "/b"}],
    }),
  );
  expect(message).toEqual({
    op: "advertise",
    channels: [{id: 1, topic: "/a", encoding: "cdr", schemaName: "", schema: ""}],
  });
});

test("messages of a newer protocol and broken ones are passed over", () => {
  for (const text of ['{"op":"newThing"}', "[]", "null", "{", ""]) {
    expect(parseText(text)).toEqual({op: "other"});
  }
});
