import {spawnSync} from "node:child_process";
import {mkdtempSync, writeFileSync} from "node:fs";
import {tmpdir} from "node:os";
import {join} from "node:path";

import {type Browser, type CDPSession, chromium, type Page} from "playwright-core";

import type {Probe} from "@page/parts/probe";

declare global {
  interface Window {
    palpate: {readonly probe: Probe};
  }
}

/// Debian's Chromium, headless, drawing by software: what a machine without a screen has.  Without what
/// only a browser's own window needs it takes half the time.
const kFind = "command -v chromium-headless-shell || command -v chromium";
const kChromium = spawnSync("sh", ["-c", kFind], {encoding: "utf8"}).stdout.trim();

export const kHasChromium = kChromium !== "";

/// For whatever a test waits for: a limit, which a slow host must not miss, and no measurement.
export const kWithinMs = 60_000;

/// Drawing by software takes all of a small machine's time; a station beside the browser must not
/// fall silent because of it.
const kNiceness = 15;

/// A page that lives for seconds gains nothing from code that a compiler works on meanwhile.
const kBrief: readonly string[] = ["--js-flags=--no-turbofan,--no-maglev"];

function politeChromium(niceness: number): string {
  const script = join(mkdtempSync(join(tmpdir(), "palpate-page-")), "chromium");
  writeFileSync(script, `#!/bin/sh\nexec nice -n ${niceness} '${kChromium}' "$@"\n`, {mode: 0o755});
  return script;
}

/// Only WebGL is drawn by the software renderer, as on a machine without a graphics card: composing
/// the whole page with it would take a sixth of a processor even while nothing changes.
export const launch = (niceness = kNiceness, more = kBrief): Promise<Browser> =>
  chromium.launch({
    executablePath: politeChromium(niceness),
    args: [
      "--disable-gpu",
      "--no-sandbox",
      "--enable-unsafe-swiftshader",
      "--disable-dev-shm-usage",
      ...more,
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
  page.setDefaultTimeout(kWithinMs);
  if (ownClock) await page.clock.install();
  page.on("pageerror", (error) => {
    throw error;
  });
  return page;
}

const kBlank = "about:blank";

/// What a window that is kept is told besides, in its own language.
interface Kept {
  readonly page: Page;
  readonly session: CDPSession;
  readonly scripts: string[]; // that run before a page's own
}
/// By the options that cannot be changed later.
const kept = new Map<string, Kept>();

async function keptWindow(browser: Browser, options: WindowOptions): Promise<Kept> {
  const key = JSON.stringify(options);
  const had = kept.get(key);
  if (had) return had;
  const page = await openWindow(browser, options);
  const session = await page.context().newCDPSession(page);
  await session.send("Page.enable"); // else no script runs first
  const one = {page, session, scripts: []};
  kept.set(key, one);
  return one;
}

/// What every window can become.
export interface PageOptions extends WindowOptions {
  before?: string; // a script that runs before the page's own
}

/// Opens a page in the window that a file's tests share.  In a new window it takes two seconds of
/// processor time; in one whose browser has compiled the page, a fifth of that.
export async function openPage(browser: Browser, url: string, options: PageOptions): Promise<Page> {
  const {viewport, colorScheme = null, reducedMotion = null, locale = "en-US", before} = options;
  const {ownClock = false, hasTouch = false, isMobile = false, timezoneId = "UTC"} = options;
  const fixed = {ownClock, hasTouch, isMobile, timezoneId};
  const {page, session, scripts} = await keptWindow(browser, fixed);
  if (viewport) await page.setViewportSize(viewport);
  await page.emulateMedia({colorScheme, reducedMotion});
  const userAgent = await page.evaluate(() => navigator.userAgent);
  await session.send("Emulation.setUserAgentOverride", {userAgent, acceptLanguage: locale});
  await session.send("Emulation.setLocaleOverride", {locale});
  if (before !== undefined) {
    const added = await session.send("Page.addScriptToEvaluateOnNewDocument", {source: before});
    scripts.push(added.identifier);
  }
  await page.goto(url);
  return page;
}

async function empty({page, session, scripts}: Kept): Promise<void> {
  for (const identifier of scripts.splice(0))
    await session.send("Page.removeScriptToEvaluateOnNewDocument", {identifier});
  await page.unrouteAll({behavior: "ignoreErrors"});
  if (page.url() === kBlank) return;
  await page.evaluate(() => {
    for (const storage of ["localStorage", "sessionStorage"] as const) {
      try {
        window[storage].clear();
      } catch {
        // A test has blocked it: it has nothing.
      }
    }
  });
  await page.goto(kBlank);
}

/// Closes the windows of one test, and empties those that a file's tests share.
export async function closeWindows(browser: Browser | undefined): Promise<void> {
  const all = [...kept.values()];
  await Promise.all(
    browser?.contexts().map((context) => {
      const one = all.find(({page}) => page.context() === context);
      return one ? empty(one) : context.close();
    }) ?? [],
  );
}

export const probe = (page: Page): Promise<Probe> => page.evaluate(() => window.palpate.probe);

/// Waits until the page's probe meets a condition; the error has the last probe.
export async function until(
  page: Page,
  what: string,
  condition: (probe: Probe) => boolean,
  withinMs = kWithinMs,
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
  withinMs = kWithinMs,
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
  withinMs = kWithinMs,
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
