import {expect, test, vi} from "vitest";

import {AccessToken} from "@page/protocol/token";

/// A tab with this fragment in its address; returns what it keeps.
function openTab(fragment = ""): Map<string, string> {
  const kept = new Map<string, string>();
  follow(fragment);
  vi.stubGlobal("history", {replaceState: (_: null, __: string, url: URL) => goTo(url.href)});
  vi.stubGlobal("sessionStorage", {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => kept.set(key, value),
  });
  return kept;
}
const goTo = (href: string): unknown => vi.stubGlobal("location", {href});
const follow = (fragment: string): unknown => goTo(`https://lab.example/${fragment}`);
const fragment = (): string => new URL(location.href).hash;

test("a token leaves the address at once, and is there when the page is loaded anew", () => {
  openTab("#token=palpate_abc&more=1");
  expect(new AccessToken().headers).toEqual({Authorization: "Bearer palpate_abc"});
  expect(fragment()).toBe("#more=1");
  expect(new AccessToken().headers).toEqual({Authorization: "Bearer palpate_abc"});
});

test("a WebSocket hands it over beside the protocols, and none where there is none", () => {
  const protocols = ["foxglove.websocket.v1"];
  openTab("#token=palpate_abc");
  expect(new AccessToken().protocols(protocols)).toEqual([
    "foxglove.websocket.v1",
    "palpate.token.palpate_abc",
  ]);
  openTab();
  const none = new AccessToken();
  expect(none.protocols(protocols)).toEqual(protocols);
  expect(none.headers).toEqual({});
});

test("what fits no header is no token, and does not stay in the address either", () => {
  for (const text of ["", "a b", "a,b", "a%0d%0ab", "a%22", "x".repeat(201)]) {
    const kept = openTab(`#token=${text}`);
    expect(new AccessToken().headers).toEqual({});
    expect(fragment()).toBe("");
    expect(kept.size).toBe(0);
  }
  openTab().set("palpate.token", "a\nb");
  expect(new AccessToken().headers).toEqual({});
});

test("a link that is followed later brings another one", () => {
  openTab("#token=one");
  const token = new AccessToken();
  expect(token.takeFromAddress()).toBe(false);
  follow("#token=two");
  expect(token.takeFromAddress()).toBe(true);
  expect(token.headers).toEqual({Authorization: "Bearer two"});
});
