// A replay on the page in a real browser, behind a gateway that does what a test says.
import {afterEach, beforeEach, expect} from "vitest";

import {
  appears,
  atGatewayUnseen,
  browser,
  gateway,
  isVisible,
  open,
  page,
  reads,
  text,
} from "./support/at_gateway";
import {eventually, type WindowOptions} from "./support/browser";
import {sessionState} from "./support/fake_gateway";
import {FakeReplay} from "./support/fake_replay";
import {kCuttable} from "./support/scene_bytes";
import {browserTest as test} from "./support/skip";

let replay: FakeReplay;

atGatewayUnseen(kCuttable);
beforeEach(() => {
  if (!browser) return;
  replay = new FakeReplay(gateway);
  replay.contents.marks = [
    {at_s: 4, number: 0, kind: "contact", text: "hand touches"},
    {at_s: 20, number: 1, kind: "bookmark", text: "the slip"},
    {at_s: 40, number: 0, kind: "fault", text: "it was quicker"},
  ];
  replay.contents.gaps = [{from_s: 30, to_s: 33, station: "hand", reason: "silent"}];
  replay.state.playing = false;
  replay.state.at_s = 10;
});
afterEach(() => replay?.die());

/// The page once it shows the replay, and may steer it unless that is locked.
async function openReplay(options: WindowOptions = {}): Promise<void> {
  replay.start();
  await open(options);
  const maySteer = !replay.contents.locked && gateway.takesMessages && gateway.allowsSteering;
  await appears(maySteer ? "#scrub" : "#replay-sign");
}

const last = (): Record<string, unknown> => replay.wishes.at(-1) ?? {};
const values = (wish: string): unknown[] =>
  replay.wishes.filter((one) => one.wish === wish).map(({value}) => value);

test("a replay is said to be one, with its recording's name, when that was, and where it is", async () => {
  await openReplay({timezoneId: "UTC", locale: "en-GB"});
  await reads("#replay-word", "Replay, paused");
  expect(await text("#replay-name")).toBe("lesson-3.mcap");
  expect(await text("#replay-when")).toBe("recorded 12 Mar 2026, 13:03");
  expect(await text("#replay-time")).toBe("0:10 / 1:00");
  expect(await page.title()).toMatch(/^Replay · /);
  // It stands still, which is no silence of anybody.
  await new Promise((resolve) => setTimeout(resolve, 2000));
  expect(await isVisible("#banner")).toBe(false);
});

test("nobody takes a tool of a replay, nor makes its scene whole, by button or key", async () => {
  await open();
  await appears("#take");
  await appears("#whole");
  replay.start();
  await appears("#replay-sign");
  expect(await isVisible("#take")).toBe(false);
  expect(await isVisible("#whole")).toBe(false);
  await page.keyboard.press("m");
  await page.keyboard.press("w");
  await page.keyboard.press(" "); // sent after them, had there been any
  await eventually("a wish", () => replay.wishes.length > 0);
  expect(replay.wishes.map(({wish}) => wish)).toEqual(["play"]);
  // When another server is there instead, all is as before.
  replay.end();
  await reads("#replay-word", "Replay, ended");
  const live = sessionState("arm", "active", "test-box", "ball", {serverRun: 7n});
  gateway.send("/palpate/session_state", live);
  await appears("#take");
  expect(await isVisible("#replay-sign")).toBe(false);
  expect(await page.title()).toMatch(/^test-box/);
});

test("keys and buttons play and pause, go from mark to mark and to both ends, and change the speed", async () => {
  await openReplay();
  await page.keyboard.press(" ");
  await reads("#replay-word", "Replay");
  expect(await page.locator("#play").getAttribute("aria-label")).toBe("Pause");
  await page.locator("#play").click();
  await reads("#replay-word", "Replay, paused");
  await page.keyboard.press(".");
  await reads("#replay-where", "the slip");
  await page.locator("#mark-after").click();
  await reads("#replay-time", "0:40 / 1:00");
  await page.keyboard.press(",");
  await page.locator("#mark-before").click(); // whether or not the first has been answered
  await reads("#replay-time", "0:04 / 1:00");
  await page.keyboard.press("End");
  await reads("#replay-time", "1:00 / 1:00");
  await page.locator("#play").focus();
  await page.keyboard.press("Home"); // a button has no use for it
  await reads("#replay-time", "0:00 / 1:00");
  await eventually("it is there", () => replay.state.at_s === 0);
  await page.locator("#panel").focus();
  await page.keyboard.press("End"); // and the panel scrolls
  await page.keyboard.press(".");
  await eventually("the contact", () => replay.state.at_s === 4);
  expect(values("seek").at(-2)).toBe(0);
  await page.keyboard.press(">");
  await page.keyboard.press(">");
  await eventually("four times the speed", () => replay.state.rate === 4);
  await page.keyboard.press("<");
  await eventually("half of that", () => replay.state.rate === 2);
  await eventually("shown", async () => (await page.locator("#rate").inputValue()) === "2");
  await page.locator("#rate").selectOption("0.25");
  await eventually("a quarter", () => replay.state.rate === 0.25);
  await page.locator("#panel").focus();
  await page.keyboard.press("?");
  expect(await text("#replay-keys")).toMatch(/Space[\s\S]*,[\s\S]*Home[\s\S]*End[\s\S]*B/);
  expect(await isVisible(".keys.of-mouse")).toBe(false);
});

test("a bookmark is named, of the moment at which it was asked for, gone to and taken away", async () => {
  await openReplay();
  replay.state.playing = true;
  await reads("#replay-word", "Replay");
  await page.keyboard.press("b");
  const atS = replay.state.at_s;
  // Its name has more bytes than it may, in letters of two; and no key of it steers anything.
  await page.keyboard.type("m, w. " + "é".repeat(60));
  replay.state.at_s += 5; // time goes by
  await page.keyboard.press("Enter");
  await eventually("it is kept", () => replay.contents.marks.length === 4);
  const bookmark = replay.contents.marks.find(({number}) => number === 2)!;
  expect(bookmark.text).toBe("m, w. " + "é".repeat(47));
  expect(Math.abs(bookmark.at_s - atS)).toBeLessThan(1);
  const row = page.locator("#marks li.bookmark", {hasText: "m, w. "});
  await row.locator(".go").click();
  await eventually("it is there", () => values("seek").at(-1) === bookmark.at_s);
  await row.locator(".drop").click();
  await eventually("it is gone", async () => (await row.count()) === 0);
  expect(replay.contents.marks.map(({number}) => number)).toEqual([0, 1, 0]);
  // Without a name it has its time.
  replay.state.playing = false;
  await page.locator("#bookmark").click();
  await page.getByRole("button", {name: "Cancel"}).click();
  await page.keyboard.press("b");
  await page.getByRole("button", {name: "Keep it"}).click();
  await eventually("it is kept", () => replay.contents.marks.length === 4);
  expect(replay.wishes.filter(({wish}) => wish === "add_bookmark").length).toBe(2);
  expect(last().text).toMatch(/^Bookmark at 0:\d\d$/);
  // Why one is not kept is said in the replayer's words.
  replay.refusal = "there are 200 bookmarks already; drop one first";
  await page.keyboard.press("b");
  await page.keyboard.press("Enter");
  await reads("#hint", /there are 200 bookmarks already/);
});

test("a bar is dragged: few wishes on the way, and the last is where it was let go of", async () => {
  await openReplay();
  const {x, y, width, height} = (await page.locator("#scrub-marks").boundingBox())!;
  const middle = y + height / 2;
  await page.mouse.move(x + width / 6, middle);
  await page.mouse.down();
  const begunMs = Date.now();
  for (let i = 0; i <= 40; ++i) await page.mouse.move(x + width * (1 / 6 + i / 80), middle);
  await page.mouse.up();
  const tookS = (Date.now() - begunMs) / 1000;
  await eventually("two thirds", () => Math.abs(replay.state.at_s - 40) < 0.5);
  expect(values("seek").length).toBeLessThanOrEqual(2 + 5 * tookS + 1);
  // Between two pixels it may be a little less.
  await reads("#replay-time", /^0:(39|40) /);
  // By key it goes second by second, and turns no camera.
  await page.locator("#scrub").focus();
  await page.keyboard.press("ArrowRight");
  await eventually("a second on", () => Math.abs(replay.state.at_s - 41) < 0.5);
  await eventually("said", async () =>
    /^4\d seconds of 1 /.test((await page.locator("#scrub").getAttribute("aria-valuetext"))!),
  );
});

test("plots stand at the recording's times, with its gaps, and begin anew after a seek", async () => {
  replay.state.at_s = 28;
  await openReplay();
  Object.assign(replay.state, {playing: true, rate: 2});
  await eventually("past the gap", () => replay.state.at_s > 35);
  replay.state.playing = false;
  await eventually("the force is the time's", async () => {
    const shown = Number.parseFloat(await text("#plots .plot:first-child output"));
    return Math.abs(shown - replay.state.at_s) < 0.3;
  });
  // Pixels of a column of the plot: grey where nothing was recorded, the curve's where it was.
  const colours = (atS: number): Promise<string[]> =>
    page.evaluate(
      ([fromNow]) => {
        const canvas = document.querySelector<HTMLCanvasElement>("#plots canvas")!;
        const over = document.querySelector<HTMLElement>("#plots .u-over")!;
        const scale = canvas.width / canvas.clientWidth;
        const x = scale * (over.offsetLeft + over.clientWidth * (1 + fromNow! / 12));
        const top = Math.ceil(scale * over.offsetTop);
        const tall = Math.floor(scale * over.clientHeight);
        const {data} = canvas.getContext("2d")!.getImageData(Math.round(x), top, 1, tall);
        const found = new Set<string>();
        for (let i = 0; i < data.length; i += 4) {
          const [r = 0, g = 0, b = 0, a = 0] = data.subarray(i, i + 4);
          if (a > 0) found.add(r - b > 60 || r > 2 * g ? "curve" : "grey");
        }
        return [...found];
      },
      [atS - replay.state.at_s],
    );
  await eventually("the curve before", async () => (await colours(29)).includes("curve"));
  expect(await colours(31.5)).toEqual(["grey"]);
  expect(await colours(34)).toContain("curve");
  await page.keyboard.press("Home");
  await reads("#replay-time", "0:00 / 1:00");
  await reads("#plots .plot:first-child output", /^0\.00/);
  await eventually(
    "no curve of before",
    async () => !(await colours(replay.state.at_s - 5)).includes("curve"),
  );
});

test("a replayer that dies, or ends, leaves no doubt of it", async () => {
  await openReplay({ownClock: true});
  replay.die();
  await page.clock.runFor(3000);
  await reads("#replay-word", "Replay, silent");
  expect(await text("#banner")).toMatch(/lesson-3.mcap has been silent for \d+ s: its program/);
  expect(await isVisible("#replay-controls")).toBe(false);
  expect(await isVisible("#take")).toBe(false);
  replay.start();
  await appears("#replay-controls");
  replay.end();
  await reads("#replay-word", "Replay, ended");
  await reads("#banner", "The replay of lesson-3.mcap has ended. You see its last state.");
  expect(await isVisible("#replay-controls")).toBe(false);
});

test("who may not steer sees the sign alone, and no key does anything", async () => {
  replay.contents.locked = true;
  await openReplay();
  const isSignAlone = async (): Promise<void> => {
    await reads("#replay-time", "0:10 / 1:00");
    for (const part of ["#replay-controls", "#marks-section", "#replay-keys"])
      expect(await isVisible(part), part).toBe(false);
    for (const key of [" ", ".", "Home", "b", ">"]) await page.keyboard.press(key);
    expect(await isVisible("#bookmark-dialog")).toBe(false);
  };
  await isSignAlone();
  replay.contents.locked = false;
  replay.tellContents();
  await appears("#scrub");
  expect(replay.wishes).toEqual([]);
  for (const rule of ["allowsSteering", "takesMessages"] as const) {
    replay.die();
    gateway[rule] = false;
    await openReplay();
    await isSignAlone();
  }
  expect(replay.wishes).toEqual([]);
});

test("a phone has room for all of it, light and dark, and a finger drags the bar", async () => {
  for (const colorScheme of ["light", "dark"] as const) {
    await openReplay({
      viewport: {width: 360, height: 740},
      hasTouch: true,
      isMobile: true,
      colorScheme,
    });
    const cut = await page.evaluate(() =>
      [...document.querySelectorAll<HTMLElement>("button, select, input, #replay-sign *")]
        .filter((part) => {
          const {left, right, width} = part.getBoundingClientRect();
          return width > 0 && (left < -1 || right > innerWidth + 1);
        })
        .map(({id}) => id),
    );
    expect(cut, colorScheme).toEqual([]);
    const small = await page.evaluate(() =>
      [...document.querySelectorAll<HTMLElement>("#replay-controls button")]
        .filter((button) => Math.min(button.offsetWidth, button.offsetHeight) < 38)
        .map(({id}) => id),
    );
    expect(small, colorScheme).toEqual([]);
    const {height} = (await page.locator(".picture").boundingBox())!;
    expect(height).toBeGreaterThan(180);
    const bar = (await page.locator("#scrub-marks").boundingBox())!;
    await page.touchscreen.tap(bar.x + bar.width / 2, bar.y + bar.height / 2);
    await eventually("the middle", () => Math.abs(replay.state.at_s - 30) < 1);
    replay.state.at_s = 10;
    replay.die();
  }
});
