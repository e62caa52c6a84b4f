import {spawnSync} from "node:child_process";
import {mkdtempSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";

import {type Browser, chromium, type Page} from "playwright-core";

import type {Probe} from "@page/parts/probe";

declare global {
  interface Window {
    palpate: {readonly probe: Probe};
  }
}

/// Debian's Chromium, headless, drawing by software: what a machine without a screen has.
const kChromium = spawnSync("sh", ["-c", "command -v chromium"], {encoding: "utf8"}).stdout.trim();

export const kHasChromium = kChromium !== "";

/// Drawing by software takes all of a small machine's time; a station beside the browser must not
/// fall silent because of it.
const kNiceness = 15;

function politeChromium(niceness: number): string {
  const script = join(mkdtempSync(join(tmpdir(), "palpate-page-")), "chromium");
  writeFileSync(script, `#!/bin/sh\nexec nice -n ${niceness} '${kChromium}' "$@"\n`, {mode: 0o755});
  return script;
}

/// Only WebGL is drawn by the software renderer, as on a machine without a graphics card: composing
/// the whole page with it would take a sixth of a processor even while nothing changes.
export const launch = (niceness = kNiceness): Promise<Browser> =>
  chromium.launch({
    executablePath: politeChromium(niceness),
    args: [
      "--disable-gpu",
      "--no-sandbox",
      "--enable-unsafe-swiftshader",
      "--disable-dev-shm-usage",
    ],
  });

export interface WindowOptions extends NonNullable<Parameters<Browser["newContext"]>[0]> {
  ownClock?: boolean; // of which time can pass at once: `page.clock.runFor`
}

/// A window of its own, before a page is loaded; what the page throws, the test throws.
export async function openWindow(
  browser: Browser,
  {ownClock = false, ...options}: WindowOptions,
): Promise<Page> {
  const page = await (await browser.newContext(options)).newPage();
  if (ownClock) await page.clock.install();
  page.on("pageerror", (error) => {
    throw error;
  });
  return page;
}

const kBlank = "about:blank";
/// By the options that cannot be changed later.
const kept = new Map<string, Page>();

/// Opens a page in the window that a file's tests share.  In a new window it takes two seconds of
/// processor time; in one whose browser has compiled the page, a fifth of that.
export async function openPage(
  browser: Browser,
  url: string,
  {viewport, colorScheme = null, ...fixed}: WindowOptions,
): Promise<Page> {
  const key = JSON.stringify(fixed);
  const page = kept.get(key) ?? (await openWindow(browser, fixed));
  kept.set(key, page);
  if (viewport) await page.setViewportSize(viewport);
  await page.emulateMedia({colorScheme});
  await page.goto(url);
  return page;
}

/// Closes the windows of one test, and empties those that a file's tests share.
export async function closeWindows(browser: Browser | undefined): Promise<void> {
  const keptPages = [...kept.values()];
  await Promise.all(
    browser?.contexts().map(async (context) => {
      const page = keptPages.find((one) => one.context() === context);
      if (!page) return context.close();
      await page.unrouteAll({behavior: "ignoreErrors"});
      if (page.url() === kBlank) return;
      await page.evaluate(() => {
        localStorage.clear();
        sessionStorage.clear();
      });
      await page.goto(kBlank);
    }) ?? [],
  );
}

export const probe = (page: Page): Promise<Probe> => page.evaluate(() => window.palpate.probe);

/// Waits until the page's probe meets a condition; the error has the last probe.
export async function until(
  page: Page,
  what: string,
  condition: (probe: Probe) => boolean,
  withinMs = 20_000,
): Promise<Probe> {
  const end = Date.now() + withinMs;
  for (;;) {
    const now = await probe(page);
    if (condition(now)) return now;
    if (Date.now() > end)
      throw new Error(`${what}: not so within ${withinMs} ms: ${JSON.stringify(now)}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/// Waits until a condition holds; throws if it does not in time.
export async function eventually(
  what: string,
  condition: () => Promise<boolean> | boolean,
  withinMs = 60_000,
): Promise<void> {
  const end = Date.now() + withinMs;
  while (!(await condition())) {
    if (Date.now() > end) throw new Error(`${what}: not so within ${withinMs} ms`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/// Waits until a part of the page has this text; the error has the text that it had instead.
export async function readsOn(
  page: Page,
  selector: string,
  wanted: string | RegExp,
  withinMs = 60_000,
): Promise<void> {
  let said = "";
  try {
    await eventually(
      selector,
      async () => {
        said = (await page.locator(selector).innerText()).replace(/\s+/g, " ");
        return typeof wanted === "string" ? said === wanted : wanted.test(said);
      },
      withinMs,
    );
  } catch {
    throw new Error(`${selector}: not ${wanted} within ${withinMs} ms: ${said}`);
  }
}
