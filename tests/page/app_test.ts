// The page in a real browser, at a gateway that does what a test says.
import {expect} from "vitest";

import {
  appears,
  atGateway,
  firstPicture,
  gateway,
  giveTools,
  isVisible,
  load,
  move,
  open,
  openWith,
  page,
  reads,
  startGateway,
  stopMoving,
  text,
  vanishes,
} from "./support/at_gateway";
import type {Probe} from "@page/parts/probe";

import {eventually, probe, until} from "./support/browser";
import {pressed, sessionState, stationStatistics, toolState} from "./support/fake_gateway";
import {kCuttable, kMarked, kTestScene, type TestScene} from "./support/scene_bytes";
import {kExercise, ownExam} from "./support/exam_state";
import {browserTest as test} from "./support/skip";
import {shadedPixels} from "./support/visible_pixels";
import {aroundPit, kPitBlock, pit, solidBlock} from "./support/solid_blocks";

const kCut: TestScene = {...kCuttable, name: "cut"};

/// Whose tool is a bur.
const kDrilled: TestScene = {
  ...kMarked,
  name: "drilled-1",
  tools: [{...kTestScene.tools[0]!, burRadius: 0.002}],
};

const kTeeth: TestScene = {
  ...kTestScene,
  name: "teeth",
  objects: ["upper-left-canine", "lower-right-first-molar"].map((name, i) => ({
    ...kTestScene.objects[0]!,
    name,
    pose: {p: [0.03 * i, 0, 0], q: [1, 0, 0, 0]},
  })),
};

atGateway(kTestScene, kCut, kTeeth, kMarked, kDrilled);

/// A ball that is pressed on the box with `newtons`, 30 times a second.
/// @param x  where on the box, as its pictures go on
function press(newtons: number, x = (_sequence: number): number => 0): void {
  gateway.retained.length = 0;
  gateway.retain("/palpate/session_state", sessionState("hand", "active", "test-box", "ball"));
  move((sequence) =>
    gateway.send("/palpate/tool_state", pressed("hand", sequence, newtons, x(sequence))),
  );
}
/// The tool to and fro along the box.
const slide = (newtons: number): void =>
  press(newtons, (sequence) => 0.01 * Math.sin((0.2 * sequence) / 33));

const kAbove = {p: [0, 0.05, 0], q: [1, 0, 0, 0]} as const;
const kFree = {haptic: kAbove, graphic: kAbove};

/// A tool that touches nothing, in the scene that burs cut.
function moveInCut(): void {
  const state = {station: "hand", scene: "cut", tool: "ball", ...kFree};
  move((poseSequence) => gateway.send("/palpate/tool_state", toolState({...state, poseSequence})));
}

const theme = (): Promise<string | undefined> =>
  page.evaluate(() => document.documentElement.dataset.theme);
/// A screenshot of the canvas alone.
const picture = async (): Promise<string> => {
  const style = ".picture > :not(canvas) { visibility: hidden }";
  return (await page.locator("#view").screenshot({style})).toString("base64");
};
/// A view that rests is drawn well after 300 ms.
const kRestMs = 400;
/// The same once it no longer changes: a busy machine shows the former picture for a while.
const stillPicture = async (): Promise<string> => {
  let {pictures} = await probe(page);
  let last = "";
  await eventually("a picture that stands still", async () => {
    await new Promise((resolve) => setTimeout(resolve, kRestMs));
    const [drawn, before] = [pictures, last];
    ({pictures} = await probe(page));
    if (drawn !== pictures) return false;
    last = await picture();
    return last === before;
  });
  return last;
};

test("the page shows the force in figures, words and picture, and draws only when it changes", async () => {
  press(0);
  await open();
  await reads("#sentence", "The tool is free.");
  expect(await text("#force")).toBe("0.00");
  const free = await picture();
  press(2);
  await reads("#force", "2.00");
  await reads("#past", "2.00");
  await reads("#contacts", "1");
  await reads("#sentence", "Contact, 2.0 newtons, hand 2.0 millimetres past the surface.");
  await eventually("the picture changes", async () => (await picture()) !== free);
  await reads("#spoken", /^Contact/);
  // The same pose goes on coming; what is drawn from now on would be drawn for nothing.
  const frames = ({stations}: Probe): number => stations.hand?.frames ?? 0;
  const told = frames(await probe(page));
  const before = await until(page, "a picture of it", (now) => frames(now) > told + 10);
  const after = await until(page, "more frames", (now) => frames(now) > frames(before) + 30);
  expect(after.pictures - before.pictures).toBeLessThanOrEqual(2);
});

test("the panel says what becomes of the force at the arm, also when the server is silent", async () => {
  press(1);
  await open({unseen: true, ownClock: true});
  const say = (more: object): void =>
    gateway.send("/palpate/station_statistics", stationStatistics("hand", more));
  const row = (label: string): Promise<string> =>
    page.getByRole("table", {name: "The arm"}).getByRole("row", {name: label}).innerText();
  expect(await text("#arm-none")).toBe("No figures yet.");
  say({slewed: 20n, warmth: 0.31});
  await eventually("the motors", async () => (await row("Motors")).includes("31 %"));
  expect(await row("Held back")).toContain("2 %");
  expect(await row("Held back")).toContain("jumps of the force");
  expect(await page.locator("#arm-none").isHidden()).toBe(true);
  // The server dies: the station alone goes on.
  stopMoving();
  await page.clock.runFor(2000);
  say({faded: 1000n, replies: 0n, silence_s_max: 2, applied_force_N_max: 0});
  await eventually("no answer", async () => (await row("Silence")).includes("2.0 s"));
  expect(await row("Held back")).toContain("replies are late or missing");
  // So does the station: what it said last is over.
  await page.clock.runFor(3000);
  await eventually("no figures", () => page.getByText("No figures now.").isVisible());
  expect(await page.locator("#arm tr").count()).toBe(0);
});

test("what stands still is drawn once, however the tool moves", async () => {
  slide(1);
  await open({}, "?quality=full");
  const before = await until(
    page,
    "the tool",
    ({pictures, stations}) => !!stations.hand && pictures > 10,
  );
  const after = await until(page, "more", ({pictures}) => pictures > before.pictures + 30);
  expect(after.drawnAnew).toBe(before.drawnAnew);
  expect(after.costs.still.triangles).toBeGreaterThan(0);
  await page.locator("#view").focus();
  await page.keyboard.press("ArrowLeft");
  await until(page, "from elsewhere", ({drawnAnew}) => drawnAnew > after.drawnAnew);
});

/// Makes each picture seem to take so long: the page judges by the times of its frames alone.
const slowPictures = (ms: number): void => {
  let atMs = 0;
  const ask = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (callback) => ask(() => callback((atMs += ms)));
};
const canvasWidth = (): Promise<number> =>
  page.evaluate(() => (document.getElementById("view") as HTMLCanvasElement).width);

test("where pictures take too long they are drawn less well, which is said, and figures stay", async () => {
  slide(1);
  await openWith(slowPictures, 100);
  await firstPicture();
  const width = await page.evaluate(() => document.getElementById("view")!.clientWidth);
  await until(page, "half the pixels", ({quality}) => quality.rest === "low");
  expect(await canvasWidth()).toBe(Math.floor(width / 2));
  expect(await text("#quality-words")).toMatch(/^At rest low: 50 % of the screen's pixels a side/);
  expect(await text("#force")).toBe("1.00");
  expect(await page.locator(".plot").count()).toBe(4);
});

test("a quality that the reader settles is taken at once, and is in the address", async () => {
  await open();
  const width = await page.evaluate(() => document.getElementById("view")!.clientWidth);
  await page.selectOption("#quality", "fair");
  await eventually("fewer pixels", async () => (await canvasWidth()) === Math.floor(0.65 * width));
  expect(page.url()).toContain("quality=fair");
});

interface Shown {
  pixels: number; // of the canvas, along its width
  points: number; // that it takes on the page
  darkest: number; // of the picture's corner, 0 to 255
}
/// Keeps what is shown at the end of each frame in which the page has drawn.
const watchPictures = (): void => {
  const shown: Shown[] = [];
  Object.assign(window, {shown});
  const small = document.createElement("canvas").getContext("2d", {willReadFrequently: true})!;
  const ask = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (callback) =>
    ask((atMs) => {
      const pictures = (): number => window.palpate?.probe.pictures ?? 0;
      const before = pictures();
      callback(atMs);
      const canvas = document.getElementById("view") as HTMLCanvasElement;
      if (pictures() === before) return;
      small.drawImage(canvas, 0, 0, 8, 8, 0, 0, 1, 1);
      const darkest = Math.min(...small.getImageData(0, 0, 1, 1).data);
      shown.push({pixels: canvas.width, points: canvas.getBoundingClientRect().width, darkest});
    });
};

test("while the view turns without a graphics card the canvas has fewer pixels, none is blank, and rest is drawn well", async () => {
  await openWith(watchPictures);
  await firstPicture();
  await page.locator("#view").focus();
  const before = await stillPicture();
  const width = await canvasWidth();
  const {drawnAnew} = await probe(page);
  for (let i = 0; i < 5; i++) await page.keyboard.press("ArrowLeft");
  await until(page, "it turned, and was drawn well", (now) => now.drawnAnew > drawnAnew + 1);
  await page.keyboard.press("r");
  await eventually("as before", async () => (await picture()) === before);
  expect(await canvasWidth()).toBe(width);
  const shown = await page.evaluate(() => (window as unknown as {shown: Shown[]}).shown);
  expect(Math.min(...shown.map(({pixels}) => pixels))).toBe(Math.floor(width / 2));
  expect(new Set(shown.map(({points}) => points)).size).toBe(1);
  expect(Math.min(...shown.map(({darkest}) => darkest))).toBeGreaterThan(100);
});

test("a picture that the graphics card has lost comes back", async () => {
  await open();
  const before = await stillPicture();
  const {drawnAnew} = await probe(page);
  await page.evaluate(() => {
    const canvas = document.getElementById("view") as HTMLCanvasElement;
    const lose = canvas.getContext("webgl2")!.getExtension("WEBGL_lose_context")!;
    canvas.addEventListener("webglcontextlost", () => setTimeout(() => lose.restoreContext()));
    lose.loseContext();
  });
  await until(page, "another picture", (now) => now.drawnAnew > drawnAnew);
  await eventually("as before", async () => (await picture()) === before);
});

test("a lost link is said, comes back by itself, and data flow again", async () => {
  press(1);
  await open({unseen: true});
  await until(page, "data", ({stations}) => (stations.hand?.frames ?? 0) > 3);
  stopMoving();
  await gateway.stop();
  await eventually("the banner", async () => (await page.locator("#banner.alarm").count()) === 1);
  expect(await text("#banner")).toMatch(/link to the gateway is lost/);
  await new Promise((resolve) => setTimeout(resolve, 1000)); // some tries go wrong
  await startGateway();
  press(3);
  await until(page, "a second link", ({links, link}) => links === 2 && link === "open");
  await reads("#force", "3.00");
  await vanishes("#banner");
});

/// Counts the pixels of a picture that are as brown as the inside of the box, and those that differ
/// otherwise from another picture.
const comparePixels = (pictures: string[]): Promise<{brown: number; others: number}> =>
  page.evaluate(async (encoded) => {
    const [of, than] = await Promise.all(
      encoded.map(async (png) => {
        const image = await createImageBitmap(
          await (await fetch(`data:image/png;base64,${png}`)).blob(),
        );
        const canvas = new OffscreenCanvas(image.width, image.height).getContext("2d")!;
        canvas.drawImage(image, 0, 0);
        return canvas.getImageData(0, 0, image.width, image.height).data;
      }),
    );
    let [brown, others] = [0, 0];
    for (let i = 0; i < of!.length; i += 4) {
      if (of![i]! > 1.6 * of![i + 2]!) brown += 1;
      else if ([0, 1, 2].some((k) => Math.abs(of![i + k]! - than![i + k]!) > 12)) others += 1;
    }
    return {brown, others};
  }, pictures);

test("what burs cut is gone from the picture, the rest looks as before, and a button, or a new run of the server, makes it whole", async () => {
  gateway.retain("/palpate/session_state", sessionState("hand", "active", "cut", "ball"));
  await open({}, "?scene=cut");
  const button = page.locator("#whole");
  await eventually("the button", () => button.isVisible());
  expect(await button.isDisabled()).toBe(true);
  const before = await stillPicture();
  const cutPit = (change: number): void => {
    const around = aroundPit("cut", change);
    for (const block of [...around, solidBlock("cut", kPitBlock, change, pit())])
      gateway.send("/palpate/solid_block", block);
  };
  cutPit(1);
  await eventually("the pit", async () => (await picture()) !== before);
  const cut = await stillPicture();
  expect(await comparePixels([before, before])).toEqual({brown: 0, others: 0});
  const {brown, others} = await comparePixels([cut, before]);
  expect(brown).toBeGreaterThan(200);
  expect(others).toBeLessThan(brown / 4); // along the pit's rim
  gateway.onPublish = ({op, scene}) => {
    if (op !== "whole") return;
    const about = {server_run: 1n, last_change: 1n, request: 9n, refusal: ""};
    gateway.send("/palpate/scene_whole", {scene, by: "the page here", ...about});
  };
  await button.click();
  await reads("#hint", "The cut is whole again (the page here).");
  await eventually("the whole box", async () => (await picture()) === before);
  expect(await button.isDisabled()).toBe(true);
  cutPit(2);
  await eventually("the pit again", async () => (await picture()) === cut);
  const anew = sessionState("hand", "active", "cut", "ball", {serverRun: 2n});
  gateway.send("/palpate/session_state", anew);
  await eventually("another box", async () => (await picture()) === before);
});

test("a tissue that comes to the surface is drawn there, and a legend names all", async () => {
  await open({}, "?scene=marked");
  const {brown} = await comparePixels([await stillPicture(), await stillPicture()]);
  expect(brown).toBeGreaterThan(200);
  await reads("#tissues", "shell core");
  const removedMm3 = [0, 1.25];
  gateway.send("/palpate/solid_block", solidBlock("marked", kPitBlock, 1, pit(), {removedMm3}));
  await reads("#tissues", "Removed shell 0.00 mm³ core 1.25 mm³");
});

test("a bur turns while its pedal is held; its depth is shown and, in practice alone, what it comes too near to", async () => {
  gateway.hasCourse = true;
  const guards = [{tissue: "core", within_mm: 1}];
  const exercise = {...kExercise, scene: "drilled", guards};
  gateway.retain("/palpate/exercises", {exercises: [exercise]});
  await open({unseen: true}, "?scene=drilled-1");
  await appears("#guard-box");
  expect(await isVisible("#pedal")).toBe(false);
  giveTools();
  await page.keyboard.press("m");
  await until(page, "the tool", ({hold}) => hold === "holding");
  await appears("#pedal");
  const stills = (): unknown[] =>
    gateway.published.filter(({op}) => op === "pose").map(({still}) => still ?? false);
  await page.keyboard.press("ArrowDown");
  await page.keyboard.down("Space");
  await eventually("it turns", () => stills().at(-1) === false);
  expect(stills()[0]).toBe(true);
  await page.waitForTimeout(300); // longer than a tap
  await page.keyboard.up("Space");
  await eventually("it stands", () => stills().at(-1) === true);
  await page.locator("#pedal").click();
  await eventually("it turns on", () => stills().at(-1) === false);
  expect(await page.locator("#pedal").getAttribute("aria-pressed")).toBe("true");

  const put = (x: number, y: number): void => {
    const graphic = {p: [x, y, 0], q: [1, 0, 0, 0]} as const;
    const state = {station: "mouse_1", scene: "drilled-1", tool: "ball", haptic: graphic, graphic};
    move((poseSequence) =>
      gateway.send("/palpate/tool_state", toolState({...state, poseSequence})),
    );
  };
  put(0.02, 0.022); // the bur's middle is 2 mm above its tip, the core a ball of 10 mm about (0, 20, 0)
  await reads("#drilled", "3.00");
  await reads("#guard", "over 2");
  put(0.0125, 0.018);
  await reads("#guard", "0.5");
  await reads("#drilled", "7.00");
  expect(await page.locator("body.near-guarded").count()).toBe(1);
  await reads("#spoken", /Near: core, 0.5 mm/);
  gateway.send("/palpate/exam_state", ownExam({exercise: kExercise}));
  await vanishes("#guard-box");
  expect(await page.locator("body.near-guarded").count()).toBe(0);
});

test("a tool casts a shadow on what it comes near to, but where pictures are as poor as can be", async () => {
  await open({}, "?scene=test-box&quality=full");
  await stillPicture();
  const at = (heightM: number): Promise<number> =>
    shadedPixels(page, {p: [0, 0.025 + 0.012 + heightM, 0], q: [1, 0, 0, 0]});
  const touching = await at(0);
  expect(touching).toBeGreaterThan(500);
  // From above it falls farther away, is softer, and is gone at last.
  expect(await at(0.005)).toBeGreaterThan(100);
  expect(await at(0.3)).toBe(0);
  await page.locator("#quality").selectOption("low");
  await stillPicture();
  expect(await at(0)).toBe(0);
});

test("what burs cut is bookmarked, and brought back to how it stood then", async () => {
  gateway.retain("/palpate/session_state", sessionState("hand", "active", "cut", "ball"));
  await open({}, "?scene=cut");
  await page.locator("#keep-cut").waitFor();
  expect(await page.locator("#back-to-cut").isDisabled()).toBe(true);
  gateway.onPublish = () => "a trial runs";
  await page.locator("#keep-cut").click();
  await reads("#hint", "It was not bookmarked: a trial runs.");
  const asked: unknown[] = [];
  gateway.onPublish = ({op, scene}) => {
    if (op !== "bookmark" && op !== "back") return;
    asked.push(op);
    const about = {server_run: 1n, last_change: 0n, request: 9n, refusal: ""};
    const answer = {wish: op === "back" ? 2 : 1, has_bookmark: true};
    gateway.send("/palpate/scene_whole", {scene, by: "the page here", ...about, ...answer});
  };
  const before = await stillPicture();
  await page.locator("#keep-cut").click();
  await reads("#hint", "The present state of cut is bookmarked (the page here).");
  for (const block of [...aroundPit("cut", 1), solidBlock("cut", kPitBlock, 1, pit())])
    gateway.send("/palpate/solid_block", block);
  await eventually("the pit", async () => (await picture()) !== before);
  await page.locator("#back-to-cut").click();
  await reads("#hint", "The cut is back at its bookmark (the page here).");
  // As the server tells it: blocks that are the mesh's again.
  const none = new Uint8Array(6);
  for (const block of [...aroundPit("cut", 2), solidBlock("cut", kPitBlock, 2, none)])
    gateway.send("/palpate/solid_block", {...block, surface: none, cut: false});
  await eventually("the whole box", async () => (await picture()) === before);
  expect(asked).toEqual(["bookmark", "back"]);
});

test("scenes are chosen, and remembered in the address", async () => {
  press(1);
  await open({unseen: true});
  await page.selectOption("#scene", "cut");
  await until(page, "the other scene", ({scene}) => scene === "cut");
  expect(page.url()).toContain("scene=cut");
  await reads("#sentence", "No tool is moving.");
  await page.selectOption("#scene", "test-box");
  await reads("#force", "1.00");
});

test("who has chosen nothing, or what nobody serves, sees the scene in which a tool moves", async () => {
  for (const query of ["", "?scene=typo"]) {
    await open({unseen: true}, query);
    const idle = await until(page, "a scene", ({scene}) => scene !== "");
    expect(idle.scene).toBe("test-box"); // the first one
    moveInCut();
    await until(page, "the other scene", ({scene}) => scene === "cut");
    stopMoving();
  }
});

const help = async (): Promise<string> => {
  await page.keyboard.press("?");
  const told = await text("#help-dialog");
  await page.keyboard.press("Escape");
  return told;
};

test("a student's view has force, what is touched, the scene's goal and a help, and is a switch apart", async () => {
  gateway.role = "operate";
  press(2);
  const goal = {scene: "test-box", text: "Press gently", limit_N: 1};
  gateway.retain("/palpate/goal", goal);
  await open({unseen: true}, "?view=student");
  await reads("#force", "2.00");
  await reads("#goal", /Press gently, at most 1 N/);
  expect(await text("#touched")).not.toBe("nothing");
  expect(await page.locator("#readout").getAttribute("class")).toContain("over");
  for (const hidden of ["#loop", "#arm", "#torque", "#contacts", "#goal-text"])
    expect(await page.locator(hidden).isVisible()).toBe(false);
  expect(await page.locator(".plot").count()).toBe(2);
  const readout = (await page.locator("#readout").boundingBox())!;
  const canvas = (await page.locator("#view").boundingBox())!;
  expect(readout.y + readout.height).toBeLessThanOrEqual(canvas.y);
  const student = await help();
  for (const needed of [/take the tool/, /follow the tool/, /1 N is the weight/, /Touches/])
    expect(student).toMatch(needed);
  for (const other of [/sphere tree/, /Time for a step/, /Torque\s/, /Mute/, /student/])
    expect(student).not.toMatch(other);
  await page.locator("#audience").click();
  const all = await help();
  for (const more of [/sphere tree/, /Time for a step/, /student.s view, and back/, /Mute/])
    expect(all).toMatch(more);
  for (const shown of ["#torque", "#contacts", "#goal-text"])
    expect(await page.locator(shown).isVisible()).toBe(true);
  expect(await page.locator(".plot").count()).toBe(4);
  gateway.onPublish = ({op, ...set}) => {
    if (op === "goal") gateway.send("/palpate/goal", set);
  };
  await page.locator("#goal-limit").fill("3");
  await page.locator("#goal-limit").press("Enter");
  await eventually("the wish", () => gateway.published.length === 1);
  expect(gateway.published).toEqual([{op: "goal", ...goal, limit_N: 3}]);
  await eventually("not over it any more", async () => {
    const classes = await page.locator("#readout").getAttribute("class");
    return !/\bover\b/.test(classes ?? "");
  });
  expect(page.url()).toBe(gateway.url); // nothing that a link would have to hand on
  await page.selectOption("#scene", "teeth");
  await vanishes("#goal");
  expect(await page.locator("#goal-text").inputValue()).toBe("");
});

test("spheres come on demand, level by level", async () => {
  press(0);
  await open();
  const plain = await stillPicture();
  await page.keyboard.press("s");
  expect(await text("#level-text")).toBe("leaves");
  await eventually("the leaves", async () => (await picture()) !== plain);
  const leaves = await picture();
  await page.keyboard.press("[");
  expect(await text("#level-text")).toBe("level 1 of 2");
  await eventually("the level above", async () => (await picture()) !== leaves);
  await page.keyboard.press("s");
  await eventually("the mesh again", async () => (await picture()) === plain);
});

test("the mouse takes a tool, moves it, and gives it back", async () => {
  await open({unseen: true});
  gateway.onPublish = ({op}) => {
    if (op !== "take") return;
    gateway.send("/palpate/mouse_state", {station: "mouse_1", phase: "", reason: ""});
    gateway.send("/palpate/mouse_state", {station: "mouse_1", phase: "active", reason: ""});
  };
  await page.locator("#take").click();
  await until(page, "the tool", ({hold}) => hold === "holding");
  expect(gateway.published[0]).toEqual({op: "take", scene: "test-box", tool: "ball"});
  const view = (await page.locator("#view").boundingBox())!;
  const [x, y] = [view.x + view.width / 2, view.y + view.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  expect(gateway.published.length).toBe(1); // the tool stays until the hand moves
  await page.mouse.move(x, y + 50, {steps: 5});
  await page.mouse.up();
  const poses = (): number[][] =>
    gateway.published.filter(({op}) => op === "pose").map(({p}) => p as number[]);
  await eventually("a lower pose", async () => (poses().at(-1)?.[1] ?? 1) < 0.055);
  const dragged = poses().at(-1)!;
  await page.mouse.wheel(0, -300); // away from oneself: pushes
  await eventually("a pose further away", async () => poses().at(-1)![2]! < dragged[2]! - 1e-4);
  await page.keyboard.down("Shift");
  await page.mouse.down();
  await page.mouse.move(x + 60, y + 50, {steps: 5});
  await page.mouse.up();
  await page.keyboard.up("Shift");
  const turned = (): number[] => gateway.published.at(-1)!.q as number[];
  await eventually("a turned pose", async () => Math.abs(turned()[0]!) < 0.99);
  await page.keyboard.press("Escape");
  await eventually("the release", async () => gateway.published.at(-1)!.op === "release");
  expect(await text("#take")).toBe("Take the tool");
});

test("who holds a tool is said, who may decide is offered it, and who is muted is told", async () => {
  press(2);
  await open({unseen: true});
  await reads("#force", "2.00");
  await page.locator("#take").click();
  await reads("#hint", /'hand' holds the ball. It is free once/);
  expect(gateway.published).toEqual([]);
  gateway.role = "operate";
  await page.reload();
  await reads("#force", "2.00");
  await page.locator("#take").click();
  expect(await text("#hint-text")).toBe("'hand' holds the ball.");
  await page.locator("#hint-action").click();
  await eventually("the wish", () => gateway.published.length === 1);
  expect(gateway.published).toEqual([{op: "take_back", station: "hand"}]);
  await page.keyboard.press("v"); // a student sees it, too
  expect(await isVisible("#station-note")).toBe(false);
  gateway.retain(
    "/palpate/session_state",
    sessionState("hand", "active", "test-box", "ball", {muted: true}),
  );
  await reads("#station-note", /hand is muted by a teacher/);
});

test("a tool that leaves the picture is pointed to, and comes back", async () => {
  await open({unseen: true});
  const pointer = page.locator("#tool-pointer");
  expect(await pointer.isVisible()).toBe(false);
  for (let i = 0; i < 12; i++) await page.keyboard.press("+");
  await pointer.waitFor();
  expect(await pointer.getAttribute("aria-label")).toBe("The ball is outside the view: show it");
  await pointer.click();
  await pointer.waitFor({state: "hidden"});
});

test("while a server compiles its first scene the page says so, and asks nobody for a tool", async () => {
  gateway.health = {scenes: [], compiling: {scene: "bunny", stage: "leaves", done: 0.43}};
  await load({unseen: true, viewport: {width: 390, height: 844}});
  await reads("#banner", /compiles bunny for the first time: 43 %/);
  expect(await page.locator("#take").isDisabled()).toBe(true);
  await page.keyboard.press("m");
  await reads("#hint-text", /There is no tool yet/);
  expect(gateway.published).toEqual([]);
});

test("who has gone without a word holds a tool no more", async () => {
  gateway.health = {server_run: "1"};
  press(1);
  await open({ownClock: true});
  await until(page, "data", ({stations}) => (stations.hand?.frames ?? 0) > 3);
  const pressed = await picture();
  stopMoving(); // with its server, which nobody tells of
  await page.clock.runFor(2000);
  await eventually("a banner", async () => (await page.locator("#banner.alarm").count()) === 1);
  await eventually("no arrows", async () => (await picture()) !== pressed);
  gateway.retained.length = 0;
  gateway.health = {server_run: "2"};
  await page.clock.runFor(4000); // until the gateway is asked again
  await reads("#banner", /Nobody moves a tool/);
  giveTools();
  await page.locator("#take").click();
  await until(page, "the tool", ({hold}) => hold === "holding");
});

test("who gives a tool back may take it again at once", async () => {
  await open({unseen: true});
  gateway.onPublish = ({op}) => {
    if (op !== "take") return;
    const here = {station: "mouse_1", scene: "test-box", tool: "ball"};
    gateway.send("/palpate/session_state", sessionState("mouse_1", "active", "test-box", "ball"));
    gateway.send("/palpate/tool_state", toolState({...here, ...kFree, poseSequence: 9}));
    gateway.send("/palpate/mouse_state", {station: "mouse_1", phase: "active", reason: ""});
  };
  for (let time = 0; time < 2; time++) {
    await page.keyboard.press("m");
    await until(page, "the tool", ({hold}) => hold === "holding");
    await page.keyboard.press("Escape");
    await until(page, "no tool", ({hold}) => hold === "none");
  }
  expect(gateway.published.filter(({op}) => op === "take").length).toBe(2);
});

test("a wish for a tool can be taken back, and its refusal is said in the gateway's words", async () => {
  await open({unseen: true});
  await page.locator("#take").click();
  await reads("#take", "Cancel");
  await page.locator("#take").click();
  await eventually("the release", async () => gateway.published.at(-1)?.op === "release");
  expect(await text("#take")).toBe("Take the tool");
  const refusal = {station: "", phase: "refused", reason: "4 tools are held"};
  gateway.onPublish = () => gateway.send("/palpate/mouse_state", refusal);
  await page.keyboard.press("m");
  await reads("#hint", "4 tools are held");
  expect(await text("#take")).toBe("Take the tool");
});

test("a gateway that gives no tools is not asked for one", async () => {
  gateway.takesMessages = false;
  await open({unseen: true});
  await vanishes("#take");
  await reads("#banner", "Nobody moves a tool. Start a station.");
  await page.keyboard.press("m");
  await page.keyboard.press("?");
  expect(await isVisible("#help-dialog")).toBe(true);
  expect(await text("#help-dialog")).not.toMatch(/take the tool|Mute/); // of those who may
  await page.locator("#help-dialog button").click();
  expect(await isVisible("#help-dialog")).toBe(false);
  expect(await isVisible("#hint")).toBe(false);
});

test("who is turned away is told so", async () => {
  gateway.turnsAway = true;
  await open({unseen: true, ownClock: true}); // scenes come without a link
  const askAgain = (): Promise<void> => page.clock.runFor(4000);
  await askAgain();
  await reads("#banner", /refuses this page/);
  gateway.health = {viewers: 300, max_viewers: 300};
  await askAgain();
  await reads("#banner", /as many viewers as/);
  gateway.turnsAway = false;
  await askAgain();
  await until(page, "a link", ({link}) => link === "open");
});

test("without WebGL the figures are live, and the page says what is missing", async () => {
  press(2);
  await openWith(() => {
    const get = HTMLCanvasElement.prototype.getContext as (...all: unknown[]) => unknown;
    Object.assign(HTMLCanvasElement.prototype, {
      getContext(this: HTMLCanvasElement, kind: string, ...more: unknown[]) {
        return kind.startsWith("webgl") ? null : get.call(this, kind, ...more);
      },
    });
  });
  await reads("#force", "2.00");
  await reads("#banner", /no WebGL/);
});

test("another scene's picture does not stay while its own is not there", async () => {
  press(1);
  await open();
  const box = await picture();
  const delay = new Promise<void>((resolve) => void page.once("close", () => resolve()));
  await page.route("**/scene/cut.bundle", async (route) => {
    await delay;
    await route.abort();
  });
  await page.selectOption("#scene", "cut");
  await until(page, "the other scene", ({scene}) => scene === "cut");
  const empty = await picture();
  expect(empty).not.toBe(box);
  expect(await isVisible("#loading")).toBe(true);
  // One that nobody waits for any more takes no word away from the one that is there.
  await page.selectOption("#scene", "test-box");
  await reads("#force", "1.00");
  await vanishes("#loading");
});

test("arrows scroll the figures where those have the focus", async () => {
  press(0);
  await open({viewport: {width: 800, height: 360}});
  await reads("#sentence", "The tool is free.");
  const before = await stillPicture();
  await page.locator("#panel").focus();
  await page.keyboard.press("ArrowDown");
  await eventually("a scroll", () =>
    page.evaluate(() => document.getElementById("panel")!.scrollTop > 0),
  );
  expect(await picture()).toBe(before);
});

test("light and dark are switched also where the browser keeps nothing", async () => {
  press(0);
  await openWith(() => {
    Object.defineProperty(window, "localStorage", {
      get: () => {
        throw new DOMException("blocked", "SecurityError");
      },
    });
  });
  await eventually("a theme", async () => (await theme()) === "light");
  await page.keyboard.press("t");
  expect(await theme()).toBe("dark");
  await page.keyboard.press("t");
  expect(await theme()).toBe("light");
});

test("a finger moves the tool on a phone", async () => {
  await open({unseen: true, viewport: {width: 360, height: 640}, hasTouch: true, isMobile: true});
  giveTools();
  await page.locator("#take").tap();
  await until(page, "the tool", ({hold}) => hold === "holding");
  const session = await page.context().newCDPSession(page);
  const touch = (type: "touchStart" | "touchMove" | "touchEnd", y: number): Promise<unknown> =>
    session.send("Input.dispatchTouchEvent", {
      type,
      touchPoints: type === "touchEnd" ? [] : [{x: 180, y}],
    });
  await touch("touchStart", 200);
  for (let y = 205; y <= 240; y += 5) await touch("touchMove", y);
  await touch("touchEnd", 0);
  await eventually("a lower pose", async () => {
    const last = gateway.published.filter(({op}) => op === "pose").at(-1)?.p as
      | number[]
      | undefined;
    return (last?.[1] ?? 1) < 0.055;
  });
});

test("nothing is cut off from phone to projector, nor jumps with the line above the picture", async () => {
  press(1);
  for (const [width, height] of [
    [360, 640],
    [1280, 720],
    [1920, 1080],
  ] as const) {
    await open({unseen: true, viewport: {width, height}});
    const outside = await page.evaluate(() => {
      const cut: string[] = [];
      for (const element of document.querySelectorAll("button, select, output, .sentence")) {
        const {left, right, width: wide} = element.getBoundingClientRect();
        if (wide > 0 && (left < 0 || right > innerWidth + 0.5)) cut.push(element.id);
      }
      if (document.documentElement.scrollWidth > innerWidth) cut.push("the page");
      for (const element of document.querySelectorAll<HTMLElement>(".tools, .bar")) {
        if (element.scrollWidth > element.clientWidth + 1) cut.push(element.className);
      }
      return cut;
    });
    expect(outside, `${width} × ${height}`).toEqual([]);
    const tops = await page.evaluate(() => {
      const top = (): number => document.querySelector("#view")!.getBoundingClientRect().top;
      const before = top();
      document.querySelector("#touched")!.textContent =
        "upper left second premolar, upper left first molar, lower jaw";
      document.querySelector("#sentence")!.textContent =
        "Contact, 12.3 newtons, hand 10.4 millimetres past the surface.";
      return [before, top()];
    });
    expect(tops[1], `${width} × ${height}`).toBe(tops[0]);
  }
});

test("figures are not read out each time, and every key in the help does something", async () => {
  press(0);
  await open();
  // Figures that change ten times a second are not to be read out each time.
  expect(await page.locator("output:not([aria-live=off])").count()).toBe(1); // the slider's
  await page.keyboard.press("?");
  expect(await isVisible("#help-dialog")).toBe(true);
  await page.keyboard.press("Escape");
  await page.keyboard.press("f");
  expect(await page.locator("#follow").getAttribute("aria-pressed")).toBe("true");
  await page.keyboard.press("p");
  expect(await isVisible("#panel")).toBe(false);
  const before = await picture();
  await page.keyboard.press("ArrowLeft");
  await eventually("another view", async () => (await picture()) !== before);
  await page.keyboard.press("r");
});

test("light and dark follow the system, and the reader's choice outlives the visit", async () => {
  press(0);
  await open({unseen: true, colorScheme: "dark"});
  expect(await theme()).toBe("dark");
  await page.emulateMedia({colorScheme: "light"});
  await eventually("light", async () => (await theme()) === "light");
  await page.keyboard.press("t");
  expect(await theme()).toBe("dark");
  await page.reload();
  expect(await theme()).toBe("dark");
});

test("teeth are numbered on demand, where there are any", async () => {
  await open({unseen: true});
  expect(await isVisible("#numbers")).toBe(false);
  await open({unseen: true}, "?scene=teeth");
  await eventually("a button", () => page.locator("#numbers").isVisible());
  expect(await isVisible("#labels")).toBe(false);
  await page.keyboard.press("n");
  await eventually(
    "two numbers",
    async () => (await page.locator("#labels span:visible").allInnerTexts()).join() === "23,46",
  );
  const picture = (await page.locator("#view").boundingBox())!;
  await eventually("both within the picture", async () => {
    const boxes = await Promise.all(
      (await page.locator("#labels span").all()).map((label) => label.boundingBox()),
    );
    return boxes.every((b) => b && b.x > picture.x + 1 && b.y > picture.y + 1);
  });
  await page.keyboard.press("n");
  expect(await isVisible("#labels")).toBe(false);
});
