// Another language, chosen while the page is in use, in a real browser at a gateway that does what a test
// says.
import {expect} from "vitest";

import {
  atGatewayUnseen,
  chooseLanguage,
  gateway,
  giveTools,
  move,
  open,
  page,
  reads,
  stopMoving,
} from "./support/at_gateway";
import {eventually, probe, until} from "./support/browser";
import {heldExam, kExercise, trialState} from "./support/exam_state";
import {loopStatistics, pressed, sessionState, stationStatistics} from "./support/fake_gateway";
import {FakeReplay} from "./support/fake_replay";
import {kClassHistory, kPersonHistory} from "./support/made_up_history";
import {kTestScene} from "./support/scene_bytes";
import {browserTest as test} from "./support/skip";

const kSeat = {...kTestScene, name: `${kTestScene.name}-1`};

atGatewayUnseen(kTestScene, kSeat);

/// All that the page says, hidden or not, without the figures, which change by themselves.
const said = (): Promise<string[]> =>
  page.evaluate(() => {
    const all: string[] = [];
    const own =
      "dialog:not([open]), .of-class[hidden], .clock, .chart, #language, #quality-words, #hint, " +
      "#spoken, #banner";
    for (const one of document.querySelectorAll("body *")) {
      if (one.closest(own) || one.closest("script, noscript")) continue;
      const texts = [...one.childNodes].filter(({nodeType}) => nodeType === Node.TEXT_NODE);
      const attributes = ["title", "aria-label", "placeholder", "alt"];
      for (const text of [
        ...texts.map(({textContent}) => textContent ?? ""),
        ...attributes.map((name) => one.getAttribute(name) ?? ""),
      ]) {
        const words = text.replace(/[\d.,–]+/g, "#").trim();
        if (words !== "") all.push(`${one.tagName.toLowerCase()}#${one.id}: ${words}`);
      }
    }
    return all;
  });

const closeDialogs = (): Promise<void> =>
  page.evaluate(() => {
    for (const one of document.querySelectorAll<HTMLDialogElement>("dialog[open]")) one.close();
  });

/// A state of the page, and what brings it there.
type State = readonly [name: string, bring: () => Promise<void>];

/// Goes through the languages in place, in each state; then opens the same page in each language.
/// @param show  opens it in a language
async function sameAsOpenedInEach(
  show: (locale: string) => Promise<void>,
  states: readonly State[],
): Promise<void> {
  const settled = async (): Promise<string[]> => {
    await page.waitForTimeout(300); // what the page tells ten times a second
    return said();
  };
  await show("en-GB");
  const inPlace = new Map<string, string[]>();
  for (const [name, bring] of states) {
    await bring();
    for (const language of ["de", "zh", "en"]) {
      await chooseLanguage(language);
      inPlace.set(`${name} in ${language}`, await settled());
    }
    await closeDialogs();
  }
  for (const language of ["de", "zh", "en"]) {
    await page.evaluate(() => localStorage.clear());
    await show(language);
    for (const [name, bring] of states) {
      await bring();
      const state = `${name} in ${language}`;
      expect(inPlace.get(state), state).toEqual(await settled());
      await closeDialogs();
    }
  }
}

/// A course in which Anna presses too hard, and Zoe waits to be admitted.
function haveCourse(role: string): void {
  gateway.role = role;
  gateway.hasCourse = true;
  const person = {person: 2, name: "Anna", role: "drive", station: "Anna", here: 1, seat: ""};
  const others = [
    {...person, seat: kSeat.name},
    {...person, person: 3, name: "Ben", station: "Ben", here: 0},
    {...person, person: 1, name: "teacher", role: "operate", station: "teacher"},
  ];
  gateway.retain("/palpate/people", {scene: kTestScene.name, people: others});
  gateway.retain("/palpate/goal", {scene: kTestScene.name, text: "Gently", limit_N: 0.25});
  gateway.retain("/palpate/session_state", sessionState("Anna", "active", kTestScene.name, "ball"));
  gateway.retain("/palpate/session_state", sessionState("Zoe", "held", kTestScene.name, "ball"));
  gateway.files.set("/history/class.json", JSON.stringify(kClassHistory));
  gateway.files.set("/history/2.json", JSON.stringify(kPersonHistory));
  move((sequence) => {
    gateway.send("/palpate/tool_state", pressed("Anna", sequence, 0.5));
    gateway.send("/palpate/loop_statistics", loopStatistics("Anna", kTestScene.name));
    gateway.send("/palpate/station_statistics", stationStatistics("Anna"));
  });
}

const openClass = async (): Promise<void> => {
  await page.locator("#class-open").click();
  await page.locator(".wall li").nth(2).waitFor({state: "attached"});
  await page.locator(".roster li").nth(2).waitFor({state: "attached"});
};
const openHistory = async (): Promise<void> => {
  await page.locator("#history-open").click();
  await page.locator("#history-dialog tbody tr").first().waitFor();
};

test("a teacher's page says in place what it says where opened", async () => {
  haveCourse("operate");
  gateway.retain("/palpate/exam_state", heldExam());
  await sameAsOpenedInEach(
    async (locale) => {
      await open({viewport: {width: 1280, height: 800}, locale});
      await page.locator("#console li").nth(1).waitFor();
      await page.locator("#loop td").first().waitFor();
    },
    [
      ["the class", openClass],
      [
        "an exam",
        async () => {
          await page.locator("#exam-open").click();
          await page.locator("#exam-dialog tbody tr").first().waitFor();
        },
      ],
      ["the class's history", openHistory],
      [
        "a person's history",
        async () => {
          await openHistory();
          await page.locator("#history-dialog .name", {hasText: "Ben"}).click();
          await page.locator("#history-dialog article").first().waitFor();
        },
      ],
    ],
  );
});

test("so does a student's in a trial, and after it", async () => {
  const done = {
    n: 1,
    points: 60,
    passed: false,
    whole: false,
    submitted: false,
    reason: "",
    page: "a",
  };
  gateway.retain("/palpate/exercises", {exercises: [{...kExercise, done: [done], guide: []}]});
  haveCourse("drive");
  const trial = (state: string, more: Parameters<typeof trialState>[1]): State => [
    state,
    async () => {
      gateway.send("/palpate/trial_state", trialState(state, more));
      await page.locator("#trial-bar").waitFor();
      await page.locator("#exercises-open").click();
      await page.locator("#exercises-dialog .done li").first().waitFor();
    },
  ];
  await sameAsOpenedInEach(
    (locale) => open({locale}, "?view=student"),
    [
      trial("running", {submitted: false}),
      trial("scored", {points: 81, passed: true, submitted: false}),
      trial("unscored", {
        reason: "its recording is cut off; no score: its recorder ended",
        whole: false,
      }),
    ],
  );
});

test("so does a replay", async () => {
  const replay = new FakeReplay(gateway);
  replay.contents.marks.push({at_s: 0.1, number: 1, kind: "bookmark", text: "the slip"});
  replay.start();
  await sameAsOpenedInEach(
    (locale) => open({viewport: {width: 1280, height: 800}, locale}),
    [["a replay", () => page.locator("#marks li").waitFor()]],
  );
  replay.die();
});

test("in another language nothing is lost: what was typed, where it was scrolled, the tool, the trial, the link", async () => {
  haveCourse("operate");
  stopMoving(); // the tool is free
  gateway.retain("/palpate/exercises", {exercises: [{...kExercise, guide: []}]});
  giveTools();
  await open({viewport: {width: 1280, height: 500}});
  await page.locator("#take").click();
  await until(page, "the tool", ({hold}) => hold === "holding");
  gateway.send("/palpate/trial_state", trialState("running"));
  await page.locator("#trial-bar .clock", {hasText: /\d/}).waitFor();
  await page.keyboard.press("Tab");
  await page.locator("#class-open").click();
  await page.getByRole("button", {name: "People"}).click();
  await page.fill("#class-names", "Dora\nEmil");
  await page.locator(".roster li", {hasText: "Ben"}).getByRole("button", {name: "Rename"}).click();
  await page.locator(".roster .rename input").fill("Benno");
  await page.keyboard.press("Escape");
  await page.fill("#goal-text", "Still typed");
  const scrolled = (): Promise<number> =>
    page.evaluate(() => document.querySelector("#panel")!.scrollTop);
  const {links} = await probe(page);
  await page.keyboard.press("Tab");
  await page.locator("#settings").click();
  await page.evaluate(() => {
    Object.assign(window, {isSame: true});
    document.querySelector("#panel")!.scrollTop = 120;
  });
  const before = await scrolled();
  expect(before).toBeGreaterThan(0);
  await page.selectOption("#language", "de");
  await reads("#take", "Zurückgeben");
  await page.keyboard.press("Escape");
  expect(page.url()).toBe(gateway.url);
  expect(await page.evaluate(() => (window as unknown as {isSame: boolean}).isSame)).toBe(true);
  const now = await probe(page);
  expect([now.links, now.hold]).toEqual([links, "holding"]);
  expect(await scrolled()).toBe(before);
  expect(await page.inputValue("#class-names")).toBe("Dora\nEmil");
  expect(await page.inputValue(".roster .rename input")).toBe("Benno");
  await reads("#trial-bar .clock", /^\d+ s$/);
  await eventually("the goal", () => gateway.published.some(({text}) => text === "Still typed"));
  await page.reload();
  await reads("#take", "Instrument nehmen"); // it is kept
});
