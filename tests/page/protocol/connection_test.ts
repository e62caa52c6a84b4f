import {afterEach, beforeEach, describe, expect, test, vi} from "vitest";

import {Connection} from "@page/protocol/connection";

import {encode, kChannels, toolState} from "../support/fake_gateway";

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

/// A socket that does what a test says.
class FakeSocket {
  readyState = 0;
  binaryType = "";
  readonly sent: (string | Uint8Array)[] = [];
  onopen: (() => void) | null = null;
  onclose: (() => void) | null = null;
  onmessage: ((event: {data: unknown}) => void) | null = null;
  send(data: string | Uint8Array): void {
    this.sent.push(data);
  }
  close(): void {
    if (this.readyState === 3) return;
    this.readyState = 3;
    this.onclose?.();
  }
  open(): void {
    this.readyState = 1;
    this.onopen?.();
  }
  say(message: object): void {
    this.onmessage?.({data: JSON.stringify(message)});
  }
}

function rig() {
  const sockets: FakeSocket[] = [];
  const links: string[] = [];
  const messages: {topic: string; value: unknown}[] = [];
  const statuses: string[] = [];
  const allowed: boolean[] = [];
  const offered: ReadonlySet<string>[] = [];
  const connection = new Connection(
    (topic) => topic === "/palpate/tool_state",
    {
      link: (state) => links.push(state),
      message: (topic, value) => messages.push({topic, value}),
      status: (_level, message) => statuses.push(message),
      mayPublish: (may) => allowed.push(may),
      offers: (topics) => offered.push(topics),
    },
    () => {
      const socket = new FakeSocket();
      sockets.push(socket);
      return socket as unknown as WebSocket;
    },
  );
  connection.open();
  /// Time goes on to what is due next; returns how much.
  const fire = (): number => {
    const before = Date.now();
    vi.advanceTimersToNextTimer();
    return Date.now() - before;
  };
  return {connection, sockets, links, messages, statuses, allowed, offered, fire};
}

const kServerInfo = {op: "serverInfo", name: "x", capabilities: ["clientPublish"]};
const kAdvertise = {op: "advertise", channels: kChannels};

describe("a connection", () => {
  test("subscribes to what it was asked for and to nothing else", () => {
    const {sockets, statuses} = rig();
    const socket = sockets[0]!;
    socket.open();
    socket.say(kServerInfo);
    socket.say(kAdvertise);
    socket.say(kAdvertise); // a gateway that repeats itself
    expect(statuses).toEqual([]);
    expect(socket.sent.map((text) => JSON.parse(text as string))).toEqual([
      {op: "subscribe", subscriptions: [{id: 0, channelId: 1}]},
    ]);
  });

  test("is not disturbed by a channel that it cannot read", () => {
    const {sockets, statuses} = rig();
    const socket = sockets[0]!;
    socket.open();
    const broken = {...kChannels[0]!, id: 99, schema: "this is no IDL {"};
    socket.say({op: "advertise", channels: [broken, ...kChannels]});
    expect(statuses).toEqual([expect.stringMatching(/tool_state: its schema could not be read/)]);
    expect(socket.sent.length).toBe(1);
  });

  test("gives a message to whom its subscription belongs", () => {
    const {sockets, messages, statuses} = rig();
    const socket = sockets[0]!;
    socket.open();
    socket.say(kAdvertise);
    const payload = encode("/palpate/tool_state", toolState({station: "hand", scene: "s"}));
    const frame = (subscription: number, content: Uint8Array): ArrayBuffer => {
      const bytes = new Uint8Array(13 + content.length);
      bytes.set([1, subscription]);
      bytes.set(content, 13);
      return bytes.buffer;
    };
    socket.onmessage?.({data: frame(0, payload)});
    socket.onmessage?.({data: frame(9, payload)});
    socket.onmessage?.({data: frame(0, payload.subarray(0, 40))});
    expect(messages.length).toBe(1);
    expect(messages[0]).toMatchObject({topic: "/palpate/tool_state", value: {station: "hand"}});
    expect(statuses[0]).toMatch(/could not be read/);
  });

  test("comes back by itself, after two seconds at most, and subscribes again", () => {
    const {sockets, links, fire} = rig();
    sockets[0]!.open();
    const waits: number[] = [];
    sockets[0]!.close();
    for (let i = 0; i < 6; i++) {
      waits.push(fire());
      sockets.at(-1)!.close();
    }
    expect(waits).toEqual([250, 500, 1000, 2000, 2000, 2000]);
    fire();
    const last = sockets.at(-1)!;
    last.open();
    last.say(kAdvertise);
    expect(links.at(-1)).toBe("open");
    expect(JSON.parse(last.sent[0] as string)).toMatchObject({op: "subscribe"});
    last.close();
    expect(fire()).toBe(250); // patience is back
  });

  test("gives up a gateway that does not answer", () => {
    const {sockets, links, fire} = rig();
    expect(fire()).toBe(3000);
    expect(sockets[0]!.readyState).toBe(3);
    expect(links).toEqual(["connecting", "lost"]);
  });

  test("gives up a socket that only looks open, and tries at once", () => {
    const {connection, sockets, links} = rig();
    sockets[0]!.open();
    connection.restart();
    expect(sockets[0]!.readyState).toBe(3);
    expect(sockets.length).toBe(2);
    expect(links).toEqual(["connecting", "open", "lost", "connecting"]);
    sockets[1]!.open();
    expect(links.at(-1)).toBe("open");
  });

  test("tells which topics the gateway has, and whether it takes messages", () => {
    const {connection, sockets, allowed, offered} = rig();
    sockets[0]!.open();
    sockets[0]!.say(kServerInfo);
    expect(offered).toEqual([]);
    sockets[0]!.say(kAdvertise);
    expect([...offered[0]!]).toEqual(kChannels.map(({topic}) => topic));
    sockets[0]!.say({...kServerInfo, capabilities: []});
    expect(allowed).toEqual([true, false]);
    expect(connection.publish("/palpate/mouse", {op: "release"})).toBe(false);
  });

  test("publishes once the gateway takes messages, and advertises once a socket", () => {
    const {connection, sockets} = rig();
    const socket = sockets[0]!;
    expect(connection.publish("/palpate/mouse", {op: "release"})).toBe(false);
    socket.open();
    expect(connection.publish("/palpate/mouse", {op: "release"})).toBe(false);
    socket.say(kServerInfo);
    expect(connection.publish("/palpate/mouse", {op: "release"})).toBe(true);
    expect(connection.publish("/palpate/mouse", {op: "release"})).toBe(true);
    expect(socket.sent.filter((data) => typeof data === "string").length).toBe(1);
    expect(socket.sent.filter((data) => data instanceof Uint8Array).length).toBe(2);
  });
});
