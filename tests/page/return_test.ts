// A page in a trial that goes and comes back, in a real browser, at the real programs.
import {execFileSync} from "node:child_process";
import {mkdtempSync, rmSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";

import {afterAll, beforeAll, expect} from "vitest";

import type {Browser, Page} from "playwright-core";

import {kHasChromium, launch, openWindow, probe, readsOn, until} from "./support/browser";
import {type Program, startGateway, startServer} from "./support/programs";
import {browserTest as test} from "./support/skip";

let browser: Browser;
let page: Page;
let folder = "";
let server: Program;
let gateway: Program;

beforeAll(async () => {
  if (!kHasChromium) return;
  folder = mkdtempSync(join(tmpdir(), "palpate-course-"));
  browser = await launch();
  server = await startServer("periodontal");
  let url: string;
  ({gateway, url} = await startGateway("--course", folder));
  const [, token] = await gateway.says(/#(token=\w+)/);
  page = await openWindow(browser, {viewport: {width: 500, height: 500}});
  await page.goto(`${url}#${token}`);
  await until(page, "a first picture", ({firstPictureMs}) => firstPictureMs !== undefined);
});
afterAll(async () => {
  if (!kHasChromium) return;
  await browser?.close();
  for (const program of [gateway, server]) await program?.stop();
  rmSync(folder, {recursive: true});
});

/// Processes that this one has begun, and theirs, that are of the browser.
function browserProcesses(): number[] {
  const rows = execFileSync("ps", ["-eo", "pid=,ppid=,comm="], {encoding: "utf8"}).trim();
  const all = rows.split("\n").map((row) => row.trim().split(/\s+/));
  const within = new Set([String(process.pid)]);
  for (const [pid, parent] of all) if (within.has(parent!)) within.add(pid!);
  return all
    .filter(([pid, , name]) => within.has(pid!) && /chrom/.test(name!))
    .map(([pid]) => +pid!);
}

/// Where the hand is, and the tool.
const own = async () => Object.values((await probe(page)).stations)[0]!;

test("a page that is loaded again goes on in its trial, and so does one that was frozen", async () => {
  await page.locator("#exercises-open").click();
  await page.getByRole("button", {name: "Begin", exact: true}).click();
  await readsOn(page, "#trial-bar", /Go\./);
  await until(page, "a tool", ({hold}) => hold === "holding");
  await page.locator("#view").focus();
  for (let step = 0; step < 4; step++) await page.keyboard.press("ArrowDown");
  await until(page, "a tool that moves", ({stations}) => Object.keys(stations).length > 0);
  await page.waitForTimeout(500);
  const before = await own();
  await page.reload();
  await until(page, "the tool again", ({hold}) => hold === "holding");
  await readsOn(page, "#trial-bar", /Go\./);
  expect((await own()).graphic.p[1]).toBeCloseTo(before.graphic.p[1], 4);
  await page.locator("#view").focus();
  for (let step = 0; step < 4; step++) await page.keyboard.press("ArrowDown");
  await until(page, "motion", ({stations}) =>
    Object.values(stations).some(({graphic}) => graphic.p[1] < before.graphic.p[1] - 1e-4),
  );
  const pids = browserProcesses();
  for (const pid of pids) process.kill(pid, "SIGSTOP");
  await gateway.says(/rests: its page is missing[^]*rests: its page is missing/);
  for (const pid of pids) process.kill(pid, "SIGCONT");
  await gateway.says(/goes on: its page is back[^]*goes on: its page is back/);
  expect((await probe(page)).hold).toBe("holding");
  await page.locator("#trial-bar").getByRole("button", {name: "Stop"}).click();
  await readsOn(page, "#trial-bar", /of 100|no score/);
  expect(gateway.output).not.toContain("cut short");
});
