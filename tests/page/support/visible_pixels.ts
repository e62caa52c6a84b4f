import type {Page} from "playwright-core";

import type {Mesh} from "three";

import type {Pose, Vec3} from "@page/base/pose";
import type {SceneModel} from "@page/model/bundle";
import type {Picture} from "@page/parts/picture";

/// The page's parts, which TypeScript alone calls private.
interface Parts {
  readonly picture: Picture & {readonly canvas: HTMLCanvasElement};
}

/// Counts the pixels at which a reader sees the working end of the scene's first tool: those of the picture
/// that change if it is left out, and over which nothing of the page lies.
/// @param pose  where the tool is put, with the hand
export const visiblePixels = (page: Page, pose: Pose): Promise<number> =>
  page.evaluate(async (at) => {
    const {view, canvas} = (window.palpate as unknown as Parts).picture;
    // What the view keeps to itself, and this test must know.
    const own = view as unknown as {
      renderer: {getContext(): WebGL2RenderingContext};
      sightM: number;
      tools: {
        name: string;
        end: [number, number, number];
        body: {mesh: Mesh; body: {geometry: {radiusM: number}}};
      }[];
    };
    const [tool] = own.tools;
    if (!tool) throw new Error("no tool");
    const still = {
      forceN: [0, 0, 0],
      torqueNm: [0, 0, 0],
      points: [],
      moved: [],
      contacts: 0,
    } as const;
    view.setTool(tool.name, {...still, haptic: at, graphic: at} as never);
    const gl = own.renderer.getContext();
    const [width, height] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
    const draw = (): Uint8Array => {
      view.render(performance.now());
      const pixels = new Uint8Array(4 * width * height);
      gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      return pixels;
    };
    let ms: number | undefined;
    while (
      (view.render(performance.now()), (ms = view.settlesInMs(performance.now()))) !== undefined
    )
      await new Promise((resolve) => setTimeout(resolve, ms)); // the same view, drawn better
    const withEnd = draw();
    const {geometry} = tool.body.mesh;
    const all = geometry.index!;
    const reachM = tool.body.body.geometry.radiusM > 1.3 * own.sightM ? 0.6 * own.sightM : Infinity;
    const position = geometry.getAttribute("position");
    const isFar = (i: number): boolean =>
      Math.hypot(
        position.getX(i) - tool.end[0],
        position.getY(i) - tool.end[1],
        position.getZ(i) - tool.end[2],
      ) > reachM;
    const rest: number[] = [];
    for (let k = 0; k + 2 < all.count && reachM < Infinity; k += 3) {
      const corners = [all.getX(k), all.getX(k + 1), all.getX(k + 2)];
      if (corners.every(isFar)) rest.push(...corners);
    }
    if (reachM < Infinity) geometry.setIndex(rest);
    else geometry.setDrawRange(0, 0);
    const withoutEnd = draw();
    geometry.setIndex(all);
    geometry.setDrawRange(0, Infinity);
    const box = canvas.getBoundingClientRect();
    const per = box.width / width;
    const free = new Map<number, boolean>(); // whether nothing covers a cell of the window
    const isFree = (x: number, y: number): boolean => {
      const cell = 4096 * (y >> 2) + (x >> 2);
      let is = free.get(cell);
      if (is === undefined) free.set(cell, (is = document.elementFromPoint(x, y) === canvas));
      return is;
    };
    let seen = 0;
    for (let i = 0; i < withEnd.length; i += 4) {
      const change =
        Math.abs(withEnd[i]! - withoutEnd[i]!) +
        Math.abs(withEnd[i + 1]! - withoutEnd[i + 1]!) +
        Math.abs(withEnd[i + 2]! - withoutEnd[i + 2]!);
      if (change < 30) continue;
      const x = box.left + per * (((i / 4) % width) + 0.5);
      const y = box.top + per * (height - 0.5 - Math.floor(i / 4 / width));
      if (isFree(x, y)) seen += per * per;
    }
    return seen;
  }, pose);

/// Counts the pixels of the canvas that the scene's first tool makes darker where it is put, without itself.
export const shadedPixels = (page: Page, pose: Pose): Promise<number> =>
  page.evaluate(async (at) => {
    const {view} = (window.palpate as unknown as Parts).picture;
    const own = view as unknown as {
      renderer: {getContext(): WebGL2RenderingContext};
      tools: {name: string; groups: {visible: boolean}[]}[];
    };
    const {name, groups} = own.tools[0]!;
    const gl = own.renderer.getContext();
    const still = {
      forceN: [0, 0, 0],
      torqueNm: [0, 0, 0],
      points: [],
      moved: [],
      contacts: 0,
    } as const;
    const put = (graphic: Pose): void =>
      view.setTool(name, {...still, haptic: graphic, graphic} as never);
    put(at); // a view that is new looks at it
    let ms: number | undefined;
    while (
      (view.render(performance.now()), (ms = view.settlesInMs(performance.now()))) !== undefined
    )
      await new Promise((resolve) => setTimeout(resolve, ms)); // the same view, drawn better
    const lightWith = (graphic: Pose): number[] => {
      put(graphic);
      for (const group of groups) group.visible = false;
      view.render(performance.now());
      const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
      gl.readPixels(
        0,
        0,
        gl.drawingBufferWidth,
        gl.drawingBufferHeight,
        gl.RGBA,
        gl.UNSIGNED_BYTE,
        pixels,
      );
      const light: number[] = [];
      for (let i = 0; i < pixels.length; i += 4)
        light.push(pixels[i]! + pixels[i + 1]! + pixels[i + 2]!);
      return light;
    };
    const near = lightWith(at);
    const far = lightWith({...at, p: [0, 10, 0]});
    groups[0]!.visible = true; // the tool itself; its ghosts and marks show on their own
    return near.filter((light, i) => light < far[i]! - 9).length;
  }, pose);

/// Where the tool starts, and where its end is in the middle of the work, within what is there.
export const poses = (page: Page): Promise<Record<"start" | "inside", Pose>> =>
  page.evaluate(async () => {
    const frame = (): Promise<number> => new Promise(requestAnimationFrame);
    for (let n = 0; n < 2; n++) await frame(); // the page takes up what covers it now
    const {view} = (window.palpate as unknown as Parts).picture;
    const {model, tools} = view as unknown as {
      model: SceneModel;
      tools: {endInWorld: Vec3; pose: Pose}[];
    };
    const {pose: now, endInWorld} = tools[0]!;
    const start = model.tools[0]!.pose;
    const middle = model.firstSight?.centre ?? model.objects[0]!.pose.p;
    const p = now.p.map((x, i) => x + middle[i]! - endInWorld[i]!) as unknown as Vec3;
    return {start, inside: {...start, p}};
  });
