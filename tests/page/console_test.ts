// A teacher's console and the token that a page hands over, in a real browser at a gateway that does
// what a test says.
import {expect} from "vitest";

import {
  appears,
  atGatewayUnseen,
  browser,
  gateway,
  isVisible,
  load,
  move,
  open,
  page,
  reads,
  text,
  vanishes,
} from "./support/at_gateway";
import {eventually, openWindow, until} from "./support/browser";
import {loopStatistics, pressed, sessionState} from "./support/fake_gateway";
import {kTestScene} from "./support/scene_bytes";
import {browserTest as test} from "./support/skip";

atGatewayUnseen(kTestScene);

const tell = (station: string, phase: string, more: object = {}): void =>
  gateway.retain("/palpate/session_state", sessionState(station, phase, "test-box", "ball", more));

/// The right hand presses beyond what its tool can follow.
const pressOn = (): void =>
  move((sequence) => {
    gateway.send("/palpate/tool_state", pressed("right", sequence, 2));
    if (sequence % 660 === 0)
      gateway.send("/palpate/loop_statistics", loopStatistics("right", "test-box", {faults: 8}));
  });

const row = (station: string) =>
  page.locator("#console li").filter({has: page.locator("b", {hasText: station})});

test("a teacher sees who is there and how that goes, those who wait first, and decides", async () => {
  gateway.role = "operate";
  tell("left", "active", {muted: true});
  tell("right", "active");
  tell("zoe", "held");
  tell("gone", "ended");
  pressOn();
  await open();
  await row("zoe").waitFor();
  expect(await page.locator("#console li b").allInnerTexts()).toEqual(["zoe", "left", "right"]);
  expect(await row("left").innerText()).toMatch(/drives the ball of test-box, without forces/);
  await eventually("the fault", async () =>
    /jammed between surfaces/.test(await row("right").innerText()),
  );
  expect(await isVisible("#who-section")).toBe(false);
  if (process.env.PALPATE_PICTURE) await page.screenshot({path: process.env.PALPATE_PICTURE});

  const press = (station: string, button: string): Promise<void> =>
    row(station).getByRole("button", {name: button, exact: true}).click();
  await press("zoe", "Admit");
  expect(await row("zoe").getByRole("button", {name: "Admit"}).isDisabled()).toBe(true);
  await press("left", "Unmute");
  await press("right", "Mute");
  await eventually("three wishes", () => gateway.published.length === 3);
  expect(gateway.published).toEqual([
    {op: "admit", station: "zoe"},
    {op: "unmute", station: "left"},
    {op: "mute", station: "right"},
  ]);
  // The server answers by what it says of the stations.
  tell("zoe", "active");
  tell("right", "active", {muted: true});
  await eventually(
    "all in the order of their names",
    async () => (await page.locator("#console li b").allInnerTexts()).join() === "left,right,zoe",
  );
  await row("right").getByRole("button", {name: "Unmute"}).waitFor();
  await press("zoe", "Take back");
  await eventually("the wish", () => gateway.published.length === 4);
  expect(gateway.published[3]).toEqual({op: "take_back", station: "zoe"});
  tell("zoe", "ended");
  await row("zoe").waitFor({state: "detached"});
});

test("a wish that nobody answers can be made again", async () => {
  gateway.role = "operate";
  tell("right", "active");
  await open({ownClock: true});
  const mute = row("right").getByRole("button", {name: "Mute"});
  await mute.click();
  expect(await mute.isDisabled()).toBe(true);
  await page.clock.runFor(4000);
  await eventually("the button", () => mute.isEnabled());
});

test("the console is not for those who may not decide, nor in a student's view", async () => {
  gateway.role = "drive";
  tell("right", "active");
  await open();
  await page.locator("#who li").waitFor();
  expect(await isVisible("#console-section")).toBe(false);
  gateway.role = "operate";
  await page.reload();
  await page.locator("#console-section").waitFor();
  await page.keyboard.press("?");
  expect(await text("#help-dialog")).toMatch(/Mute[\s\S]*Take back/);
  // However long it is, it begins at its top.
  expect(await page.locator("#help-dialog").evaluate(({scrollTop}) => scrollTop)).toBe(0);
  await page.keyboard.press("Escape");
  await page.keyboard.press("v");
  await page.locator("#console-section").waitFor({state: "hidden"});
  expect(await isVisible("#who-section")).toBe(true);
});

test("a page hands over the token of its address, which stands there no longer", async () => {
  gateway.token = "palpate_0123";
  await load();
  await reads("#banner", /link that you were given/);
  await page.goto(gateway.url + "#token=wrong");
  await reads("#banner", /link that you were given/);
  // In the same tab, without loading the page anew.
  await page.goto(gateway.url + "#token=palpate_0123");
  await until(
    page,
    "the link and the scene",
    ({link, firstPictureMs}) => link === "open" && firstPictureMs !== undefined,
  );
  expect(page.url()).toBe(gateway.url);
  await page.reload();
  await until(page, "the link again", ({link}) => link === "open");
  // Another tab knows nothing of it.
  const other = await openWindow(browser!, {});
  await other.goto(gateway.url);
  await eventually("its own banner", async () =>
    /link that you were given/.test(await other.locator("#banner").innerText()),
  );
});
