import {afterEach, beforeEach, expect, test, vi} from "vitest";

import {kIdentity, type Pose, type Vec3} from "@page/base/pose";
import {MouseDevice} from "@page/mouse/mouse_device";

const kStart: Pose = {p: [0, 0.06, 0], q: [1, 0, 0, 0]};
const at = (p: Vec3): Pose => ({...kIdentity, p});

let still = false;
let published: {op: string; p?: Vec3; still?: boolean}[];
let tools: Map<string, {pose: Pose; touches: boolean; centroid: Vec3}>; // by station
let canvas: EventTarget;
let mouse: MouseDevice;

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("window", globalThis);
  published = [];
  tools = new Map();
  canvas = new EventTarget();
  mouse = new MouseDevice({
    publish: (message) => published.push(message as {op: string}) > 0,
    changed: () => {},
    still: () => still,
    viewFrame: () => ({
      ...{right: [1, 0, 0], up: [0, 1, 0], forward: [0, 0, -1], metresPerPixel: 0.001},
    }),
    tool: (station) => tools.get(station),
  });
  mouse.listenTo(canvas as HTMLCanvasElement, {enabled: true});
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const active = (station: string) => ({
  ...{station, scene: "cube", tool: "ball", phase: "active" as const, reason: ""},
});

function take(station: string): void {
  mouse.take("cube", "ball");
  mouse.receive(active(station));
}
function press(key: string): void {
  canvas.dispatchEvent(Object.assign(new Event("keydown"), {key}));
  vi.advanceTimersByTime(100);
}
const poses = (): Vec3[] => published.filter(({op}) => op === "pose").map(({p}) => p!);

test("a tool that is taken stays where its station begins until the hand moves", () => {
  tools.set("anna", {pose: kStart, touches: false, centroid: [0, 0, 0]});
  take("anna");
  vi.advanceTimersByTime(1000);
  expect(poses()).toEqual([]);
  press("ArrowRight");
  expect(poses()).toEqual([[0.008, 0.06, 0]]);
});

test("a tool that is taken once more begins anew, not where the last one was let go", () => {
  tools.set("anna", {pose: kStart, touches: false, centroid: [0, 0, 0]});
  take("anna");
  press("ArrowDown");
  mouse.release();
  tools.set("anna", {pose: at([0.5, 0, 0]), touches: false, centroid: [0, 0, 0]});
  take("anna");
  vi.advanceTimersByTime(1000);
  press("ArrowRight");
  expect(poses().slice(1)).toEqual([[0.508, 0, 0]]);
});

test("a bur's pedal is told with the pose, also where the hand rests, and not before it has moved", () => {
  tools.set("anna", {pose: kStart, touches: false, centroid: [0, 0, 0]});
  take("anna");
  still = true;
  mouse.pedalled();
  vi.advanceTimersByTime(100);
  expect(poses()).toEqual([]);
  press("ArrowRight");
  for (const now of [false, false, true]) {
    still = now;
    mouse.pedalled();
    vi.advanceTimersByTime(100);
  }
  still = false;
  const told = published.filter(({op}) => op === "pose");
  expect(told.map((pose) => pose.still ?? false)).toEqual([true, false, true]);
  expect(new Set(told.map(({p}) => String(p))).size).toBe(1);
});

test("a wheel that was pushing when the tool was taken away does not zoom before it has paused", () => {
  vi.stubGlobal("WheelEvent", {DOM_DELTA_LINE: 1});
  tools.set("anna", {pose: kStart, touches: false, centroid: [0, 0, 0]});
  let zooms = 0;
  canvas.addEventListener("wheel", () => (zooms += 1));
  const wheel = (): void => {
    const roll = Object.assign(new Event("wheel", {cancelable: true}), {deltaY: 3, deltaMode: 0});
    canvas.dispatchEvent(roll);
    vi.advanceTimersByTime(400);
  };
  wheel();
  expect(zooms).toBe(1);
  take("anna");
  wheel();
  mouse.receive({...active("anna"), phase: "ended", reason: "time"});
  zooms = 0;
  wheel();
  wheel();
  expect(zooms).toBe(0);
  vi.advanceTimersByTime(700);
  wheel();
  expect(zooms).toBe(1);
});

test("a hand moves nothing whose place is not known yet", () => {
  take("anna");
  press("ArrowRight");
  expect(poses()).toEqual([]);
});

test("a page that has just come goes on with the tool of its trial, and with no other", () => {
  tools.set("anna", {pose: kStart, touches: false, centroid: [0, 0, 0]});
  mouse.receive(active("anna"));
  press("ArrowRight");
  expect(poses()).toEqual([[0.008, 0.06, 0]]);
  mouse.release();
  mouse.receive(active("anna")); // on its way when the tool was given back
  expect(mouse.hold).toBe("none");
});
