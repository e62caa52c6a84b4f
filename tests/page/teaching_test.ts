// The page in a real browser, at the real server, station and gateway.
import {mkdtempSync, rmSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";

import {afterAll, afterEach, beforeAll, beforeEach, describe, expect} from "vitest";

import type {Browser, Page} from "playwright-core";

import type {Probe} from "@page/parts/probe";
import {norm, subtract} from "@page/base/pose";

import {
  closeWindows,
  eventually,
  kHasChromium,
  launch,
  openPage,
  openWindow,
  probe,
  readsOn,
  until,
} from "./support/browser";
import {type Program, startGateway, startHand, startServer} from "./support/programs";
import {browserTest as test} from "./support/skip";

let browser: Browser;
let server: Program;
let gateway: Program;
let station: Program;
let url = "";

/// A pyramid that nobody has made a scene of; in millimetres.
function writeTooth(file: string): void {
  const corners = ["-10 0 -10", "-10 0 10", "10 0 10", "10 0 -10", "0 14 0"];
  const faces = [
    [0, 2, 1],
    [0, 3, 2],
    [0, 1, 4],
    [1, 2, 4],
    [2, 3, 4],
    [3, 0, 4],
  ];
  const facet = (face: number[]): string =>
    `facet normal 0 0 0\nouter loop\n${face.map((i) => `vertex ${corners[i]}\n`).join("")}endloop\nendfacet\n`;
  writeFileSync(file, `solid tooth\n${faces.map(facet).join("")}endsolid tooth\n`);
}

beforeAll(async () => {
  if (!kHasChromium) return;
  browser = await launch();
  const folder = mkdtempSync(join(tmpdir(), "palpate-tooth-"));
  writeTooth(join(folder, "tooth.stl"));
  server = await startServer("bunny-bunny", join(folder, "tooth.stl"));
  rmSync(folder, {recursive: true}); // nobody but the server has it
  ({gateway, url} = await startGateway());
});
afterAll(async () => {
  if (!kHasChromium) return;
  await browser?.close();
  for (const program of [gateway, server]) await program?.stop();
});

const kWindow = {viewport: {width: 400, height: 400}};

afterEach(() => closeWindows(browser));

async function open(query = "", page?: Page): Promise<Page> {
  if (page) await page.goto(url + query);
  else page = await openPage(browser, url + query, kWindow);
  await until(page, "a first picture", ({firstPictureMs}) => firstPictureMs !== undefined);
  return page;
}

describe("while a simulated hand feels the bunny", () => {
  beforeEach(async () => {
    if (!kHasChromium) return;
    station = startHand("simulated", "bunny-bunny");
    await station.says(/session: tool/);
  });
  afterEach(() => station?.stop());

  test("the page shows the scene and a moving tool, and says how it goes", async () => {
    const page = await open();
    const first = await until(page, "the hand", ({stations}) => stations.hand !== undefined);
    console.log(`first picture after ${first.firstPictureMs!.toFixed(0)} ms`);
    const before = await page.locator("#view").screenshot();
    const moved = await until(
      page,
      "the tool elsewhere",
      ({stations, pictures}) =>
        norm(subtract(stations.hand!.graphic.p, first.stations.hand!.graphic.p)) > 0.005 &&
        pictures > first.pictures + 3,
    );
    expect(moved.stations.hand!.poseSequence).toBeGreaterThan(first.stations.hand!.poseSequence);
    // The hand may rest for a moment where the first picture was taken.
    await eventually(
      "another picture",
      async () => !(await page.locator("#view").screenshot()).equals(before),
    );
    await readsOn(page, "#sentence", /^Contact, .* newtons/);
    await readsOn(page, "#who", /hand drives the bunny of bunny-bunny/);
    await readsOn(page, "#loop", /Rate \d+ \/ s .* Late [\d,]+ poses? /);
    // What the station says of its arm, through the real gateway.
    await readsOn(page, "#arm", /Device in order PHANTOM Premium 3\.0/);
    const {scriptMs, pictures} = await probe(page);
    console.log(`script ${scriptMs.toFixed(2)} ms a picture over ${pictures} pictures`);
  });
});

/// The mouse's station, whose name is the gateway's choice.
const mouseOf = ({stations}: Probe): Probe["stations"][string] | undefined =>
  Object.entries(stations).find(([id]) => id.startsWith("mouse_"))?.[1];

/// Takes the tool and drags it down on the fixed bunny until it pushes back, stroke by stroke as a
/// hand does: where the machine is busy, the tool is slower than the pointer and a stroke ends
/// above the bunny.
async function press(page: Page): Promise<void> {
  await page.locator("#take").click();
  await until(page, "the tool", ({hold}) => hold === "holding");
  await until(page, "its station", (now) => mouseOf(now) !== undefined);
  const view = (await page.locator("#view").boundingBox())!;
  const x = view.x + view.width / 2;
  for (let stroke = 0; stroke < 3; stroke++) {
    await page.mouse.move(x, view.y + 40);
    await page.mouse.down();
    for (let y = view.y + 40; y < view.y + view.height - 10; y += 4) {
      await page.mouse.move(x, y);
      await new Promise((resolve) => setTimeout(resolve, 50));
      const station = mouseOf(await probe(page));
      if (station === undefined) throw new Error("the session has ended");
      if (norm(station.forceN) > 0.5) return;
    }
    await page.mouse.up();
  }
  throw new Error("three strokes met nothing");
}

const release = async (page: Page): Promise<void> => {
  await page.mouse.up();
  await page.keyboard.press("Escape");
  await readsOn(page, "#who", /mouse_\w+ has left/);
};

const kSilenced = /station mouse_\w+: ended: no pose came for more than 100 ms/;

/// Presses, and checks what is so while the tool is held.  A machine that is too busy silences a
/// station for longer than a server waits, which ends its session, at any moment of this.  Only
/// then, and where the server says so, is there another try: a mouse that is served all the while
/// and meets nothing, or of which the page says nothing, is a failure.
const whilePressed = async (page: Page, check: () => Promise<void>) => {
  for (let tries = 1; ; tries++) {
    const said = server.output.length;
    try {
      await press(page);
      await check();
      return;
    } catch (error) {
      if (tries === 3 || !kSilenced.test(server.output.slice(said))) throw error;
    }
    await release(page);
  }
};

test("the mouse takes the ball of a mesh, and feels it", async () => {
  const page = await open("?scene=tooth");
  await whilePressed(page, async () => {});
  await release(page);
});

test("the mouse presses the bunny, and the page shows the force", async () => {
  const page = await open("?scene=bunny-bunny");
  const second = await open("?scene=bunny-bunny", await openWindow(browser, kWindow));
  await whilePressed(page, async () => {
    await eventually(
      "the force",
      async () => Number(await page.locator("#force").innerText()) >= 0.5,
    );
    await readsOn(page, "#sentence", /^Contact, /);
    // A second one is refused, with who has it.
    await until(second, "the first one's tool", (now) => mouseOf(now) !== undefined);
    await second.locator("#take").click();
    try {
      await second.locator("#hint.alarm").waitFor();
    } catch (error) {
      await second.keyboard.press("Escape"); // the tool was free by now, and it has it
      throw error;
    }
    // By the page where it sees the tool move, else by the server.
    expect(await second.locator("#hint").innerText()).toMatch(
      /'mouse_\w+' holds the bunny|is driven by station 'mouse_\w+'/,
    );
  });
  await release(page);
});
