// A recording on the page in a real browser: recorded, replayed and served by the real programs.
import {mkdtempSync, readFileSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";

import {afterAll, beforeAll, expect} from "vitest";

import type {Browser, Page} from "playwright-core";

import {eventually, kHasChromium, launch, openWindow, readsOn, until} from "./support/browser";
import {kCommon, kDomain, Program, startGateway, startHand, startServer} from "./support/programs";
import {browserTest as test} from "./support/skip";

let browser: Browser;
let folder = "";
let page: Page;
const running: Program[] = [];

function run(program: Program): Program {
  running.push(program);
  return program;
}

/// The beginning of a hand's motion, until it presses on the cube.
async function record(file: string): Promise<void> {
  const server = run(await startServer("cube"));
  const recorder = run(
    new Program("palpate-record", ["-o", file, "--await-scene", "cube", ...kCommon]),
  );
  await recorder.says(/recording to/);
  const station = run(startHand("scripted", "cube"));
  // Not a length of time: on a loaded machine the hand may not have touched by then.
  await station.says(/contacts 1 .*active +slide/);
  // The recorder first: at the end of the recording the hand still holds the tool, which is thus
  // shown to a page that comes when the replay has got there already.
  for (const program of [recorder, station, server]) await program.stop("SIGINT");
}

beforeAll(async () => {
  if (!kHasChromium) return;
  folder = mkdtempSync(join(tmpdir(), "palpate-lesson-"));
  await record(join(folder, "lesson.mcap"));
  browser = await launch();
});
afterAll(async () => {
  if (!kHasChromium) return;
  await browser?.close();
  for (const program of running) await program.stop();
  rmSync(folder, {recursive: true});
});

const text = (selector: string): Promise<string> => page.locator(selector).innerText();
const reads = (selector: string, wanted: string | RegExp): Promise<void> =>
  readsOn(page, selector, wanted);

test("a recording is replayed to the page, which steers it, until the replayer is killed", async () => {
  const lesson = join(folder, "lesson.mcap");
  const replayer = run(new Program("palpate-replay", [lesson, "--stay", ...kDomain]));
  const {gateway, url} = await startGateway();
  run(gateway);
  page = await openWindow(browser, {viewport: {width: 400, height: 600}});
  await page.goto(url);
  await until(page, "a first picture", ({firstPictureMs}) => firstPictureMs !== undefined);
  await page.locator("#scrub").waitFor({state: "visible"});
  expect(await text("#replay-name")).toBe("lesson.mcap");
  await reads("#replay-word", /^Replay, paused$/);
  const seen = await until(page, "the tool", ({stations}) => stations.hand !== undefined);
  await page.keyboard.press("Home");
  // Where nobody had taken the tool yet.
  await reads("#replay-where", "");
  await reads("#force", "–");
  await page.locator("#marks li.contact .go").first().click();
  const {poseSequence} = seen.stations.hand!;
  await until(page, "earlier", ({stations}) => stations.hand!.poseSequence < poseSequence);
  await eventually("its force", async () => Number.parseFloat(await text("#force")) > 0);
  await reads("#replay-where", "hand touches");
  await page.keyboard.press("b");
  await page.keyboard.type("Hier fängt es an");
  await page.keyboard.press("Enter");
  await page.locator("#marks li.bookmark", {hasText: "Hier fängt es an"}).waitFor();
  expect(readFileSync(join(folder, "lesson.bookmarks.json"), "utf8")).toContain("fängt es an");
  await replayer.stop("SIGKILL");
  await reads("#banner", /lesson.mcap has been silent/);
});
