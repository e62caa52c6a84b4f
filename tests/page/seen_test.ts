// How much of a tool's working end a reader sees, in a real browser: each scene that is shipped, in windows
// of several sizes, alone, in a trial and in an exam; at a gateway that does what a test says.
import {spawnSync} from "node:child_process";
import {mkdtempSync, readdirSync, readFileSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {basename, join} from "node:path";
import {fileURLToPath} from "node:url";

import {afterAll, beforeAll, expect} from "vitest";

import type {Browser, Page} from "playwright-core";

import {kHasChromium, launch, openPage, until} from "./support/browser";
import {kExercise, ownExam, trialState} from "./support/exam_state";
import {FakeGateway} from "./support/fake_gateway";
import {kBin} from "./support/programs";
import {browserTest as test} from "./support/skip";
import {poses, visiblePixels} from "./support/visible_pixels";

const kRoot = fileURLToPath(new URL("../..", import.meta.url));
const kWindows = [
  {width: 1366, height: 768},
  {width: 1920, height: 1080},
  {width: 1280, height: 720},
  {width: 390, height: 844}, // a phone
  {width: 844, height: 390},
];
/// Those that have least room: how the page uses more of it does not depend on the scene, and one is seen
/// in all.
const kPhones = kWindows.slice(3);
/// One with many words.
const {title, goal} = JSON.parse(
  readFileSync(join(kRoot, "client/course/exercises/calculus-detection.exercise.json"), "utf8"),
) as object & {title: object; goal: object};
const exercise = {...kExercise, title, goal};

/// What the page is told, to be in each state.
const kStates: Record<string, readonly [topic: string, value: object][]> = {
  free: [],
  trial: [["trial_state", trialState("running")]],
  exam: [
    ["trial_state", trialState("running")],
    ["exam_state", ownExam({exercise})],
  ],
};
const kLeastPixels = 200;
/// Its strip is the largest: each scene is seen beside it, and these in every state.
const kLargest = "exam";
const kInEveryState = ["caries", "oral-cavity"];
const kInEveryWindow = "caries";

/// The scenes that are shipped, as a server would send them, but for those whose meshes are not.
function shippedScenes(): Map<string, Uint8Array> {
  const folder = mkdtempSync(join(tmpdir(), "palpate-seen-"));
  const scenes = new Map<string, Uint8Array>();
  for (const of of ["scenes/catalogue", "client/course/exercises"]) {
    for (const file of readdirSync(join(kRoot, of))) {
      // -22k: the bodies of another scene, with more leaves, which nobody sees.
      if (!/^[^.]+\.json$/.test(file) || file.includes("-22k")) continue;
      const bundle = join(folder, "scene.palpate");
      const build = ["build", join(kRoot, of, file), "-o", bundle];
      const {status, stderr} = spawnSync(join(kBin, "palpate-scene"), build, {encoding: "utf8"});
      if (status === 0) scenes.set(basename(file, ".json"), readFileSync(bundle));
      else if (!stderr.includes("is not installed")) throw new Error(stderr);
    }
  }
  rmSync(folder, {recursive: true});
  return scenes;
}

let browser: Browser;
let gateway: FakeGateway;
let page: Page;
const scenes = kHasChromium ? shippedScenes() : new Map<string, Uint8Array>();

beforeAll(async () => {
  if (!kHasChromium) return;
  browser = await launch();
  gateway = await FakeGateway.start(scenes);
  gateway.hasCourse = true;
  gateway.retain("/palpate/exercises", {exercises: [exercise]});
  gateway.onPublish = ({op}) => {
    if (op === "take") gateway.send("/palpate/mouse_state", {station: "mouse_1", phase: "active"});
  };
});
afterAll(async () => {
  if (!kHasChromium) return;
  await browser.close();
  await gateway.stop();
});

for (const scene of scenes.keys()) {
  test(`the working end of the taken tool is seen: ${scene}`, async () => {
    const seen: [where: string, pixels: number][] = [];
    page = await openPage(browser, `${gateway.url}?quality=low&scene=${scene}`, {});
    await until(page, scene, (is) => is.scene === scene && is.firstPictureMs !== undefined);
    await page.locator("#take:enabled").waitFor();
    await page.keyboard.press("m");
    await until(page, "a tool", ({hold}) => hold === "holding");
    for (const [state, told] of Object.entries(kStates)) {
      if (state !== kLargest && !kInEveryState.includes(scene)) continue;
      for (const [topic, value] of told) gateway.send(`/palpate/${topic}`, value);
      if (state !== "free") await page.locator(`#${state}-bar`).waitFor();
      for (const viewport of scene === kInEveryWindow ? kWindows : kPhones) {
        await page.setViewportSize(viewport);
        const size = `${viewport.width} x ${viewport.height}`;
        for (const [where, pose] of Object.entries(await poses(page)))
          seen.push([`${state}, ${size}, ${where}`, await visiblePixels(page, pose)]);
      }
    }
    expect(seen.filter(([, pixels]) => pixels < kLeastPixels)).toEqual([]);
  });
}
