// The page in a real browser, at the real server, station and gateway.
import {afterAll, beforeAll, beforeEach, afterEach, describe, expect} from "vitest";

import type {Browser, Page} from "playwright-core";

import {norm, subtract} from "@page/model/pose";

import {kHasChromium, launch, probe, until} from "./support/browser";
import {Program} from "./support/programs";
import {browserTest as test} from "./support/skip";

// Beside other tests and their domains (tests/integration: 10 to 34).
const kDomain = String(60 + (process.pid % 25));
const kCommon = ["--transport", "udp", "--domain", kDomain];

let browser: Browser;
let server: Program;
let gateway: Program;
let station: Program;
let url = "";

const startGateway = async (port: string): Promise<void> => {
  gateway = new Program("palpate-viewer", ["--http", port, ...kCommon]);
  url = (await gateway.says(/http:\/\/127\.0\.0\.1:\d+\//))[0];
};

beforeAll(async () => {
  if (!kHasChromium) return;
  browser = await launch();
  server = new Program("palpate-server", ["--scene", "bunny-bunny", "--realtime", "off", ...kCommon]);
  await server.says(/^ready/m, 120_000);
  await startGateway("0");
});
afterAll(async () => {
  if (!kHasChromium) return;
  await browser?.close();
  for (const program of [gateway, server]) await program?.stop();
});

async function open(query = ""): Promise<Page> {
  const page = await browser.newPage({viewport: {width: 800, height: 600}});
  await page.goto(url + query);
  await until(page, "a first picture", ({firstPictureMs}) => firstPictureMs !== undefined, 60_000);
  return page;
}

describe("while a simulated hand feels the bunny", () => {
  beforeEach(async () => {
    if (!kHasChromium) return;
    station = new Program("palpate-station", [
      ...["--device", "simulated", "--scene", "bunny-bunny", "--id", "hand", "--loop"],
      ...["--no-table", "--realtime", "off"],
      ...kCommon,
    ]);
    await station.says(/session: tool/);
  });
  afterEach(async () => {
    await station?.stop();
    await Promise.all(browser?.contexts().map((context) => context.close()) ?? []);
  });

  test("the page shows the scene and a moving tool, and says how it goes", async () => {
    const page = await open();
    const first = await until(page, "the hand", ({stations}) => stations.hand !== undefined, 60_000);
    console.log(`first picture after ${first.firstPictureMs!.toFixed(0)} ms`);
    const before = await page.locator("#view").screenshot();
    const moved = await until(
      page,
      "the tool elsewhere",
      ({stations, pictures}) =>
        norm(subtract(stations.hand!.graphic.p, first.stations.hand!.graphic.p)) > 0.005 &&
        pictures > first.pictures + 3,
      60_000,
    );
    expect(moved.stations.hand!.poseSequence).toBeGreaterThan(first.stations.hand!.poseSequence);
    expect((await page.locator("#view").screenshot()).equals(before)).toBe(false);
    await page.waitForFunction(
      () => /^Contact, .* newtons/.test(document.getElementById("sentence")!.textContent ?? ""),
      null,
      {timeout: 60_000},
    );
    await page.waitForFunction(
      () => /hand drives the bunny of bunny-bunny/.test(document.getElementById("who")!.textContent ?? ""),
      null,
      {timeout: 60_000},
    );
    const {scriptMs, pictures} = await probe(page);
    console.log(`script ${scriptMs.mean.toFixed(2)} ms a picture over ${pictures} pictures`);
  });

  test("two pages see the same: one sequence number, one pose", async () => {
    const pages = [await open(), await open()];
    const seen = pages.map(() => new Map<number, string>());
    await Promise.all(
      pages.map(async (page, i) => {
        const end = Date.now() + 20_000;
        while (Date.now() < end) {
          const {hand} = (await probe(page)).stations;
          if (hand) seen[i]!.set(hand.poseSequence, JSON.stringify([hand.haptic, hand.graphic, hand.forceN]));
          if ([...seen[0]!.keys()].filter((key) => seen[1]!.has(key)).length >= 5) break;
        }
      }),
    );
    const both = [...seen[0]!.keys()].filter((key) => seen[1]!.has(key));
    expect(both.length).toBeGreaterThan(0);
    for (const key of both) expect(seen[0]!.get(key)).toBe(seen[1]!.get(key));
  });

  test("the page says that the gateway is gone, and goes on by itself once it is back", async () => {
    const page = await open();
    await until(page, "the hand", ({stations}) => stations.hand !== undefined, 60_000);
    const port = new URL(url).port;
    await gateway.stop();
    await page.locator("#banner.alarm").waitFor({timeout: 20_000});
    expect(await page.locator("#banner").innerText()).toMatch(/link to the gateway is lost/);
    const frames = (await probe(page)).stations.hand!.frames;
    await startGateway(port);
    await until(
      page,
      "frames again",
      ({link, links, stations}) => link === "open" && links === 2 && stations.hand!.frames > frames + 5,
      60_000,
    );
    await page.locator("#banner.alarm").waitFor({state: "hidden", timeout: 20_000});
  });
});

test("the mouse presses the bunny, and the page shows the force", async () => {
  const page = await open("?scene=bunny-bunny");
  await page.locator("#take").click();
  await until(page, "the tool", ({hold}) => hold === "holding", 60_000);
  const own = (await until(page, "its station", ({stations}) => stations.mouse_1 !== undefined, 60_000)).stations;
  expect(norm(own.mouse_1!.forceN)).toBe(0);
  const view = (await page.locator("#view").boundingBox())!;
  const x = view.x + view.width / 2;
  let y = view.y + 60;
  await page.mouse.move(x, y);
  await page.mouse.down();
  // Down on the fixed bunny until it pushes back.
  let force = 0;
  while (force < 0.5) {
    y += 4;
    if (y > view.y + view.height - 10) throw new Error("the drag went all the way and met nothing");
    await page.mouse.move(x, y);
    await new Promise((resolve) => setTimeout(resolve, 60));
    force = norm((await probe(page)).stations.mouse_1!.forceN);
  }
  await page.waitForFunction(() => Number(document.getElementById("force")!.textContent) >= 0.5, null, {
    timeout: 20_000,
  });
  expect(await page.locator("#sentence").innerText()).toMatch(/^Contact, /);
  // A second one is refused, with who has it.
  const second = await open("?scene=bunny-bunny");
  await until(second, "the first one's tool", ({stations}) => stations.mouse_1 !== undefined, 60_000);
  await second.locator("#take").click();
  await second.locator("#hint.alarm").waitFor({timeout: 20_000});
  expect(await second.locator("#hint").innerText()).toMatch(/'mouse_1' holds the bunny/);
  await page.mouse.up();
  await page.keyboard.press("Escape");
  await second.waitForFunction(
    () => /mouse_1 has left/.test(document.getElementById("who")!.textContent ?? ""),
    null,
    {timeout: 20_000},
  );
});
