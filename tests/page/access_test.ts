// The page for whoever reads it by ear, by keyboard alone, from the back of a room or with another eye
// for colours.
import {readFileSync} from "node:fs";
import {createRequire} from "node:module";

import {expect} from "vitest";

import type {AxeResults} from "axe-core";

import {
  atGatewayUnseen,
  chooseLanguage,
  gateway,
  giveTools,
  move,
  open,
  openWith,
  page,
  reads,
  text,
} from "./support/at_gateway";
import {eventually, until} from "./support/browser";
import {heldExam, ownExam, trialState} from "./support/exam_state";
import {FakeReplay} from "./support/fake_replay";
import {kClassHistory, kPersonHistory} from "./support/made_up_history";
import {pressed, sessionState} from "./support/fake_gateway";
import {kTestScene, type TestScene} from "./support/scene_bytes";
import {browserTest as test} from "./support/skip";

const kAxe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

const kProbed: TestScene = {
  ...kTestScene,
  name: "probed",
  tools: [{...kTestScene.tools[0]!, name: "probe", look: "probe"}],
};

atGatewayUnseen(kTestScene, kProbed);

/// What axe has against the page as it is now, in every language, with where.
async function violations(): Promise<string[]> {
  await page.evaluate(kAxe);
  const all: string[] = [];
  for (const language of ["de", "zh", "en"]) {
    await chooseLanguage(language);
    // Colours are the same in every language, and take axe most of its time.
    const found = await violationsNow({"color-contrast": {enabled: language === "en"}});
    all.push(...found.map((one) => `${language}: ${one}`));
  }
  return all;
}
async function violationsNow(rules: object): Promise<string[]> {
  // While colours change to another theme, their contrast does not count.
  await page.evaluate(() =>
    Promise.allSettled(document.getAnimations().map((one) => one.finished)),
  );
  const {violations: found} = await page.evaluate(
    (of) =>
      (window as unknown as {axe: {run(options: object): Promise<AxeResults>}}).axe.run({
        ...{resultTypes: ["violations"], rules: of},
      }),
    rules,
  );
  return found.flatMap(({id, nodes}) =>
    nodes.map(({target, failureSummary}) => `${id}: ${target.join(" ")}: ${failureSummary}`),
  );
}

test("axe finds no violation: nothing taken, a tool held, teacher's and student's view, help, settings", async () => {
  gateway.role = "operate";
  giveTools();
  await open({viewport: {width: 1280, height: 800}});
  await page.locator("#goal-text").waitFor();
  expect(await violations(), "nothing taken").toEqual([]);
  gateway.send("/palpate/goal", {scene: "test-box", text: "Press gently", limit_N: 0.2});
  gateway.retain("/palpate/session_state", sessionState("anna", "held", "test-box", "ball"));
  gateway.retain("/palpate/session_state", sessionState("mouse_1", "active", "test-box", "ball"));
  await page.locator("#take").click();
  await until(page, "the tool", ({hold}) => hold === "holding");
  move((sequence) => gateway.send("/palpate/tool_state", pressed("mouse_1", sequence, 0.3)));
  await reads("#force", "0.30");
  await page.locator("#console li").first().waitFor();
  expect(await violations(), "a tool held, over the limit").toEqual([]);
  await page.keyboard.press("t");
  expect(await violations(), "dark").toEqual([]);
  await page.keyboard.press("?");
  expect(await violations(), "help, dark").toEqual([]);
  await page.keyboard.press("Escape");
  await page.keyboard.press("t");
  await page.keyboard.press("o");
  expect(await violations(), "settings").toEqual([]);
  await page.keyboard.press("Escape");
  await page.setViewportSize({width: 390, height: 844});
  await page.keyboard.press("v");
  expect(await violations(), "a student's phone").toEqual([]);
});

test("axe finds no violation in an exam, for who sits it and who holds it", async () => {
  gateway.hasCourse = true;
  gateway.role = "drive";
  gateway.retain("/palpate/exam_state", ownExam({cut: "the gateway was killed"}));
  await open({viewport: {width: 390, height: 844}});
  await page.locator("#exam-bar").waitFor();
  expect(await violations(), "a task, on a phone").toEqual([]);
  await chooseLanguage("de");
  await page.setViewportSize({width: 390, height: 600});
  const begin = (await page.getByRole("button", {name: "Diese Aufgabe beginnen"}).boundingBox())!;
  const bar = (await page.locator("#exam-bar").boundingBox())!;
  expect(begin.y + begin.height, "in reach without a scroll").toBeLessThan(bar.y + bar.height);
  await chooseLanguage("en");
  gateway.send("/palpate/trial_state", trialState("running"));
  await page.getByRole("button", {name: "Hand in"}).waitFor();
  expect(await violations(), "at it").toEqual([]);
  gateway.role = "operate";
  gateway.retain("/palpate/exam_state", heldExam());
  await open({viewport: {width: 1280, height: 800}});
  await page.getByRole("button", {name: "Exam", exact: true}).click();
  expect(await violations(), "an examiner's desk").toEqual([]);
  gateway.send("/palpate/exam_state", heldExam({closed: true}));
  await page.locator("#exam-dialog pre").waitFor();
  await page.keyboard.press("t");
  expect(await violations(), "closed, dark").toEqual([]);
});

test("axe finds no violation in a replay, nor in a bookmark's dialogue", async () => {
  const replay = new FakeReplay(gateway);
  replay.contents.marks.push({at_s: 0.1, number: 1, kind: "bookmark", text: "the slip"});
  replay.start();
  await open({viewport: {width: 1280, height: 800}});
  await page.locator("#marks li").waitFor();
  expect(await violations(), "replay").toEqual([]);
  await page.keyboard.press("b");
  expect(await violations(), "bookmark").toEqual([]);
  replay.die();
});

test("axe finds no violation in a class's history, nor in a person's", async () => {
  gateway.role = "operate";
  gateway.hasCourse = true;
  gateway.files.set("/history/class.json", JSON.stringify(kClassHistory));
  gateway.files.set("/history/2.json", JSON.stringify(kPersonHistory));
  await open({viewport: {width: 1280, height: 800}});
  await page.locator("#history-open").click();
  await page.locator("#history-dialog tbody tr").first().waitFor();
  expect(await violations(), "class").toEqual([]);
  await page.locator("#history-dialog .name", {hasText: "Ben"}).click();
  await page.locator("#history-dialog summary").first().click();
  await page.getByRole("button", {name: "Delete…"}).click();
  expect(await violations(), "person, asked").toEqual([]);
  await page.evaluate(() => (document.documentElement.dataset["theme"] = "dark"));
  await page.setViewportSize({width: 390, height: 844});
  expect(await violations(), "a phone, dark").toEqual([]);
});

const focused = (): Promise<string> => page.evaluate(() => document.activeElement?.id ?? "");

/// Presses Tab until this element has the focus; returns the ids on the way.
async function tabTo(id: string): Promise<string[]> {
  const way: string[] = [];
  while ((await focused()) !== id) {
    if (way.push(await focused()) > 60) throw new Error(`no way to #${id}: ${way.join(", ")}`);
    await page.keyboard.press("Tab");
  }
  return way;
}

test("by keyboard alone a tool is taken, moved and given back, and a goal is set", async () => {
  gateway.role = "operate";
  giveTools();
  await open({viewport: {width: 1280, height: 800}, reducedMotion: "reduce"});
  await page.locator("#goal-text").waitFor();
  const way = await tabTo("take");
  expect(way.indexOf("scene")).toBeLessThan(way.indexOf("view")); // as it is read
  const outline = await page.evaluate(() => getComputedStyle(document.activeElement!).outline);
  expect(outline).toMatch(/solid 2px/);
  expect(
    await page.evaluate(() => getComputedStyle(document.activeElement!).transitionDuration),
  ).toBe("0s");
  await page.keyboard.press("Enter");
  await until(page, "the tool", ({hold}) => hold === "holding");
  expect(await focused()).toBe("view");
  const poses = (): object[] => gateway.published.filter(({op}) => op === "pose");
  for (const key of ["ArrowDown", "PageUp", "Shift+ArrowLeft"]) {
    const before = poses().length;
    await page.keyboard.press(key);
    await eventually(`a pose after ${key}`, () => poses().length > before);
  }
  await page.keyboard.press("Tab"); // the picture holds nobody
  expect(await focused()).not.toBe("view");
  await page.keyboard.press("Escape");
  await until(page, "no tool", ({hold}) => hold === "none");
  await tabTo("goal-text");
  await page.keyboard.type("Press gently");
  await page.keyboard.press("Tab");
  await page.keyboard.type("0.2");
  await page.keyboard.press("Enter");
  const goal = {op: "goal", scene: "test-box", text: "Press gently", limit_N: 0.2};
  await eventually("the goal", () => gateway.published.some((one) => one.limit_N === 0.2));
  expect(gateway.published.at(-1)).toEqual(goal);
});

/// Replaces the browser's sound, and keeps how loud the page last asked it to be.
const listen = (): void => {
  class Node {
    gain = {setTargetAtTime: (loud: number): void => void Object.assign(window, {loud})};
    connect(): void {}
    start(): void {}
  }
  class Context {
    currentTime = 0;
    resume(): void {}
  }
  Object.assign(window, {AudioContext: Context, GainNode: Node, OscillatorNode: Node, loud: 0});
};
const loud = (): Promise<number> => page.evaluate(() => (window as unknown as {loud: number}).loud);

test("25 g of a probe are a bar beside the picture, which says by shape, words and tone what is too much", async () => {
  let newtons = 0.2;
  gateway.retain("/palpate/session_state", sessionState("hand", "active", "probed", "probe"));
  move((sequence) => {
    const state = {...pressed("hand", sequence, newtons), scene: "probed", tool: "probe"};
    gateway.send("/palpate/tool_state", state);
  });
  await openWith(listen, 0, "?scene=probed");
  const bar = page.locator("#force-bar");
  await reads("#force-bar-now", "0.20 N");
  await reads("#force-bar .limit", "25 g 0.245 N");
  expect(await bar.getAttribute("aria-valuetext")).toBe("0.20 N, at most 0.245 N");
  expect(await bar.locator(".word").isVisible()).toBe(false);
  newtons = 0.3;
  await bar.locator(".word").waitFor();
  await reads("#force-bar .word", "Too much force");
  await reads("#spoken", /^Too much force: 0.30 N, at most 0.245 N/);
  expect(await loud()).toBe(0); // unless it is wanted
  await page.keyboard.press("o");
  await page.locator("#force-sound").check();
  await page.locator("#left-handed").check();
  await page.keyboard.press("Escape");
  await eventually("a tone", async () => (await loud()) > 0);
  const left = async (id: string): Promise<number> => (await page.locator(id).boundingBox())!.x;
  expect(await left("#force-bar")).toBeLessThan(await left("#view"));
  expect(await left("#panel")).toBeLessThan(await left("#force-bar"));
  newtons = 0.1;
  await eventually("silence", async () => (await loud()) === 0);
  await page.reload(); // all of it is kept
  await reads("#force-bar-now", "0.10 N");
  expect(await left("#force-bar")).toBeLessThan(await left("#view"));
  expect(await page.locator("#force-sound").isChecked()).toBe(true);
});

test.each(["de", "zh"])(
  "in %s nothing is cut off on a phone, nor at a projector",
  async (locale) => {
    const goal = {scene: "test-box", text: "Press gently", limit_N: 0.2};
    gateway.retain("/palpate/goal", goal);
    await open({viewport: {width: 390, height: 844}, locale}, "?view=student");
    await page.locator("#force-bar").waitFor();
    expect(await page.locator("html").getAttribute("lang")).toBe(locale);
    const cutOff = (): Promise<string[]> =>
      page.evaluate(() =>
        [
          ...document.querySelectorAll(
            "html, .bar, .tools, .readout, .force-bar, .word, .limit, button",
          ),
        ]
          .filter((one) => one.clientWidth > 0 && one.scrollWidth > one.clientWidth + 1)
          .map((one) => one.id || one.className || one.tagName),
      );
    expect(await cutOff()).toEqual([]);
    await page.setViewportSize({width: 1280, height: 720});
    await page.keyboard.press("v");
    const size = (): Promise<number> =>
      page.evaluate(() => Number.parseFloat(getComputedStyle(document.body).fontSize));
    const before = await size();
    await page.keyboard.press("o");
    await page.locator("#projector").check();
    await page.keyboard.press("Escape");
    expect(await size()).toBeGreaterThan(1.2 * before);
    expect(await cutOff()).toEqual([]);
    expect(await violations()).toEqual([]);
  },
);
