import {expect, test} from "vitest";

import {AccessToken, type TokenHost} from "@page/protocol/token";

/// A tab: its address and what it keeps.
class Tab implements TokenHost {
  readonly kept = new Map<string, string>();
  constructor(public fragment = "") {}
  setFragment(fragment: string): void {
    this.fragment = fragment === "" ? "" : `#${fragment}`;
  }
  recall(key: string): string | null {
    return this.kept.get(key) ?? null;
  }
  keep(key: string, value: string): void {
    this.kept.set(key, value);
  }
}

test("a token leaves the address at once, and is there when the page is loaded anew", () => {
  const tab = new Tab("#token=palpate_abc&more=1");
  expect(new AccessToken(tab).headers).toEqual({Authorization: "Bearer palpate_abc"});
  expect(tab.fragment).toBe("#more=1");
  expect(new AccessToken(tab).headers).toEqual({Authorization: "Bearer palpate_abc"});
});

test("a WebSocket hands it over beside the protocols, and none where there is none", () => {
  const protocols = ["foxglove.websocket.v1"];
  expect(new AccessToken(new Tab("#token=palpate_abc")).protocols(protocols)).toEqual([
    "foxglove.websocket.v1",
    "palpate.token.palpate_abc",
  ]);
  const none = new AccessToken(new Tab());
  expect(none.protocols(protocols)).toEqual(protocols);
  expect(none.headers).toEqual({});
});

test("what fits no header is no token, and does not stay in the address either", () => {
  for (const text of ["", "a b", "a,b", "a%0d%0ab", "a%22", "x".repeat(201)]) {
    const tab = new Tab(`#token=${text}`);
    expect(new AccessToken(tab).headers).toEqual({});
    expect(tab.fragment).toBe("");
    expect(tab.kept.size).toBe(0);
  }
  const tab = new Tab();
  tab.keep("palpate.token", "a\nb");
  expect(new AccessToken(tab).headers).toEqual({});
});

test("a link that is followed later brings another one", () => {
  const tab = new Tab("#token=one");
  const token = new AccessToken(tab);
  expect(token.takeFromAddress()).toBe(false);
  tab.fragment = "#token=two";
  expect(token.takeFromAddress()).toBe(true);
  expect(token.headers).toEqual({Authorization: "Bearer two"});
});
