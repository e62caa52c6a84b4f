import {spawnSync} from "node:child_process";
import {mkdtempSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";

import {type Browser, chromium, type Page} from "playwright-core";

import type {Probe} from "@page/app";

declare global {
  interface Window {
    palpate: {readonly probe: Probe};
  }
}

/// Debian's Chromium, headless, drawing by software: what a machine without a screen has.
const kChromium = spawnSync("sh", ["-c", "command -v chromium"], {encoding: "utf8"}).stdout.trim();

export const kHasChromium = kChromium !== "";

/// Drawing by software takes all that a small machine has; a station that shares it with a browser
/// must not fall silent for that.
const kNiceness = 15;

function politeChromium(niceness: number): string {
  const script = join(mkdtempSync(join(tmpdir(), "palpate-page-")), "chromium");
  writeFileSync(script, `#!/bin/sh\nexec nice -n ${niceness} '${kChromium}' "$@"\n`, {mode: 0o755});
  return script;
}

/// The page itself is put together by the drawing library, too.
const kAllBySoftwareGl = ["--use-gl=angle", "--use-angle=swiftshader"];
/// Only WebGL is: as in a browser on a machine without a graphics card.
export const kWithoutCard: readonly string[] = ["--disable-gpu"];

export const launch = (
  drawing: readonly string[] = kAllBySoftwareGl,
  niceness = kNiceness,
): Promise<Browser> =>
  chromium.launch({
    executablePath: politeChromium(niceness),
    args: [...drawing, "--no-sandbox", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"],
  });

/// A page in a window of its own; what it throws, the test throws.
export async function openPage(
  browser: Browser,
  url: string,
  options: Parameters<Browser["newContext"]>[0],
): Promise<Page> {
  const page = await (await browser.newContext(options)).newPage();
  page.on("pageerror", (error) => {
    throw error;
  });
  await page.goto(url);
  return page;
}

export const closeWindows = (browser: Browser | undefined): Promise<void[]> =>
  Promise.all(browser?.contexts().map((context) => context.close()) ?? []);

export const probe = (page: Page): Promise<Probe> => page.evaluate(() => window.palpate.probe);

/// Resolves once the page's probe is as wanted; the error tells how it was instead.
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

/// Waits until something is so; throws where it is not within a minute.
export async function eventually(
  what: string,
  condition: () => Promise<boolean> | boolean,
): Promise<void> {
  const end = Date.now() + 60_000;
  while (!(await condition())) {
    if (Date.now() > end) throw new Error(`${what}: not so within 60 s`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}
