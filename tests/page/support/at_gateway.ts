import {afterAll, afterEach, beforeAll, beforeEach} from "vitest";

import type {Browser, Page} from "playwright-core";

import {
  closeWindows,
  kHasChromium,
  launch,
  openPage,
  type PageOptions,
  readsOn,
  until,
} from "./browser";
import {FakeGateway} from "./fake_gateway";
import {sceneBytes, type TestScene} from "./scene_bytes";

// The tests of a file share a browser; each test has a gateway and a page of its own.
export let browser: Browser | undefined;
export let gateway: FakeGateway;
export let page: Page;

let moving: NodeJS.Timeout | undefined;
let sentMs = 0;

const kWindow: PageOptions = {viewport: {width: 800, height: 500}};
let isUnseen = false;
let served = new Map<string, Uint8Array>();

/// All of WebGL but the drawing itself.
const drawNothing = (): void => {
  for (const name of ["Arrays", "Elements", "ArraysInstanced", "ElementsInstanced"])
    Object.assign(WebGL2RenderingContext.prototype, {[`draw${name}`]: () => {}});
};

/// @param scenes  that the gateway has
export function atGateway(...scenes: TestScene[]): void {
  served = new Map(scenes.map((scene) => [scene.name, sceneBytes(scene)]));
  beforeAll(async () => {
    if (kHasChromium) browser = await launch();
  });
  afterAll(() => browser?.close());
  beforeEach(async () => {
    sentMs = 0;
    if (browser) await startGateway();
  });
  afterEach(async () => {
    stopMoving();
    await closeWindows(browser);
    await gateway?.stop();
  });
}

/// Starts a gateway at the former one's port.
export async function startGateway(): Promise<void> {
  gateway = await FakeGateway.start(served, gateway?.port);
}

/// Nobody judges the picture in this file's tests.
export const atGatewayUnseen = (...scenes: TestScene[]): void => {
  isUnseen = true;
  atGateway(...scenes);
};

export interface OpenOptions extends PageOptions {
  unseen?: boolean; // nobody judges the picture: its shaders would take half of the time
}

/// Opens the page at the gateway, without waiting for anything.
export async function load(options: OpenOptions = {}, query = ""): Promise<void> {
  const {unseen = isUnseen, before = "", ...others} = options;
  const scripts = unseen ? `(${String(drawNothing)})();${before}` : before;
  const opened = {...kWindow, ...others, before: scripts};
  page = await openPage(browser!, gateway.url + query, opened);
}

export async function firstPicture(): Promise<void> {
  // A language has to be fetched first.
  await page.waitForFunction(() => "palpate" in window);
  await until(page, "a first picture", ({firstPictureMs}) => firstPictureMs !== undefined);
}

export async function open(options: OpenOptions = {}, query = ""): Promise<void> {
  await load(options, query);
  await firstPicture();
}

/// Opens the page, in which this script runs before the page's own, without waiting for anything.
export const openWith = (script: (of: number) => void, of = 0, query = ""): Promise<void> =>
  load({before: `(${String(script)})(${of})`}, query);

export const text = (selector: string): Promise<string> => page.locator(selector).innerText();
export const isVisible = (selector: string): Promise<boolean> => page.locator(selector).isVisible();

export const reads = (selector: string, wanted: string | RegExp): Promise<void> =>
  readsOn(page, selector, wanted);
export const appears = (selector: string): Promise<void> =>
  page.locator(selector).waitFor({state: "visible"});
export const vanishes = (selector: string): Promise<void> =>
  page.locator(selector).waitFor({state: "hidden"});

/// Chooses the page's language, as the settings do, and waits until the page has it.
export async function chooseLanguage(language: string): Promise<void> {
  await page.evaluate((tag) => {
    const select = document.querySelector<HTMLSelectElement>("#language")!;
    select.value = tag;
    select.dispatchEvent(new Event("change"));
  }, language);
  await page.locator(`html[lang=${language}]`).waitFor({state: "attached"});
}

/// Calls this 30 times a second, with a number that grows, until the test ends or anything else moves.
export function move(step: (sequence: number) => void): void {
  stopMoving();
  moving = setInterval(() => step((sentMs += 33)), 33);
}
export const stopMoving = (): void => clearInterval(moving);

/// Lets the gateway give a tool to every page that asks for one.
export function giveTools(): void {
  gateway.onPublish = ({op}) => {
    if (op === "take") gateway.send("/palpate/mouse_state", {station: "mouse_1", phase: "active"});
  };
}
