// The score page as palpate-replay writes it, in a real browser.
import {mkdtempSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {fileURLToPath} from "node:url";

import {afterAll, beforeAll, expect} from "vitest";

import {launch, openWindow} from "./support/browser";
import {Program} from "./support/programs";
import {browserTest as test} from "./support/skip";

const kExercise = fileURLToPath(
  new URL("../../client/course/exercises/pocket-depth.exercise.json", import.meta.url),
);
const out = mkdtempSync(join(tmpdir(), "palpate-score-"));
let browser: Awaited<ReturnType<typeof launch>>;

beforeAll(async () => {
  await new Program("palpate-replay", ["rehearse", kExercise, "--out", out]).says(/open /);
  browser = await launch();
});
afterAll(() => browser.close());

const kTexts = {
  de: {marks: "Bewertung", criterion: "Tiefen gefunden"},
  zh: {marks: "评分", criterion: "测得深度"},
  en: {marks: "Marks", criterion: "Depths found"},
};

test("the score page speaks the language of its address, and another at a click", async () => {
  const page = await openWindow(browser, {locale: "en-GB"});
  for (const [language, {marks, criterion}] of Object.entries(kTexts)) {
    await page.goto(`file://${out}/score.html#${language}`);
    await page.reload();
    expect(await page.locator("h2").first().innerText()).toBe(marks);
    expect(await page.locator("td").first().innerText()).toContain(criterion);
    expect(await page.evaluate(() => document.documentElement.lang)).toBe(language);
    expect(await page.title()).toBe(await page.locator("h1").innerText());
  }
  await page.getByRole("button", {name: "Deutsch"}).click();
  expect(await page.locator("h2").first().innerText()).toBe(kTexts.de.marks);
  expect(await page.locator("svg text").first().innerHTML()).toBe("Abstand vom Weg des Vorbilds");
  expect(await page.locator("#now li").first().innerText()).toMatch(/^Vorbild: /);
  // What is left unsaid in German is a figure, a name or a unit.
  const left = await page.evaluate(() => document.body.innerText);
  expect(left).not.toMatch(/\b(the|points|expert's|of 100|time)\b/);
});
