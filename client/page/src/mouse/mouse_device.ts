import {say, type Words} from "../messages/say";
import {type Pose, samePose, type Vec3} from "../base/pose";
import type {MouseState} from "../protocol/messages";
import {reasonWords} from "../model/reasons";
import {leash, push, roll, slide, turn, type ViewFrame} from "./tool_motion";

export type Hold = "none" | "asking" | "holding";

/// What the device needs from the page.
export interface MouseHost {
  publish(message: object): boolean;
  changed(): void;
  /// Whether the tool is a bur that stands still.
  still(): boolean;
  viewFrame(at: Vec3): ViewFrame;
  /// Returns the pose of the tool in this session, or else in the scene; whether it touches; and
  /// its centroid in its own frame.  Undefined while the scene is not known.
  tool(
    station: string,
    scene: string,
    tool: string,
  ): {pose: Pose; touches: boolean; centroid: Vec3} | undefined;
}

/// Least time between two poses sent [ms].
const kSendEveryMs = 1000 / 60;
/// Time to wait for the gateway's first answer; once it has a station started for this page it may
/// take longer, since that station must first find the server, for 30 s at most [ms].
const kAnswerWithinMs = 5000;
const kSessionWithinMs = 40_000;
/// Largest distance of the pointer beyond a surface: the most that a station's hand presses in [m].
const kReachM = 0.02;
const kWheelMetresPerPixel = 0.25; // relative to a drag of as many pixels

/// A wheel that rests for so long has been let go.
const kWheelPausesMs = 600;

/// Effect of the keys: to the right, down and away [pixels].
const kSteps: Readonly<Record<string, readonly [number, number, number]>> = {
  ArrowLeft: [-8, 0, 0],
  ArrowRight: [8, 0, 0],
  ArrowUp: [0, -8, 0],
  ArrowDown: [0, 8, 0],
  PageUp: [0, 0, 8],
  PageDown: [0, 0, -8],
};

/// A tool held by the pointer, without a haptic device: takes it through the gateway and moves it.
export class MouseDevice {
  hold: Hold = "none";
  private message: Words = "";
  station = "";
  scene = "";
  tool = "";
  private pose: Pose | undefined;
  private sent: {pose: Pose; still: boolean} | undefined;
  private lastSentMs = -Infinity;
  private timer: number | undefined;
  private patience: number | undefined;
  private readonly pointers = new Map<number, {x: number; y: number}>();
  private turning = false;
  /// When the wheel pushed last.  Who goes on after the time was over is not zooming.
  private pushedMs = -Infinity;
  /// A page that has just come, or come back, may have a tool already: that of its trial.
  private isNew = true;
  private expects = false; // the gateway chooses scene and tool

  constructor(private readonly host: MouseHost) {}

  /// @param ask  requests it in another way: a trial brings its own tool.
  take(
    scene: string,
    tool: string,
    ask = (): boolean => this.host.publish({op: "take", scene, tool}),
  ): void {
    this.isNew = this.expects = false;
    this.scene = scene;
    this.tool = tool;
    this.station = "";
    if (!ask()) {
      this.end(() => say("tool.not_from_here"));
      return;
    }
    this.hold = "asking";
    this.message = "";
    this.waitFor(() => say("tool.no_gateway_answer"), kAnswerWithinMs);
    this.host.changed();
  }

  /// Asks for a tool that the gateway chooses, as it does for a task of an exam.
  expect(ask: () => boolean): void {
    if (this.hold !== "none") return;
    this.expects = true;
    if (!ask()) this.end(() => say("tool.not_from_here"));
  }

  /// Returns a message about the tool that it holds, requests or, once, has lost.
  takeMessage(): Words {
    const message = this.message;
    if (this.hold === "none") this.message = "";
    return message;
  }

  release(): void {
    if (this.hold === "none") return;
    this.host.publish({op: "release"});
    this.end("");
  }

  linkLost(): void {
    if (this.hold !== "none") this.end(() => say("tool.link_lost"));
    this.isNew = true;
    this.expects = false;
  }

  /// Takes the gateway's answer, or a later change of the session.
  receive(state: MouseState): void {
    if (this.hold === "none") {
      const isIts = this.expects ? state.phase !== "ended" : this.isNew && state.phase === "active";
      if (!isIts) return;
      this.isNew = this.expects = false;
      [this.scene, this.tool, this.hold] = [state.scene, state.tool, "asking"];
    }
    if (state.station !== "") this.station = state.station;
    switch (state.phase) {
      case "refused":
        this.end(state.reason === "" ? () => say("tool.refused") : reasonWords(state.reason));
        break;
      case "ended":
        if (this.hold === "holding") this.end(reasonWords(state.reason));
        break;
      case "waiting":
      case "acquiring":
      case "active":
        if (this.hold === "asking") this.begin();
        this.message = state.phase === "acquiring" ? reasonWords(state.reason) : "";
        this.host.changed();
        break;
      case "held":
        // A teacher decides when.
        window.clearTimeout(this.patience);
        this.message = () => say("tool.waits");
        this.host.changed();
        break;
      case "":
        if (this.hold === "asking")
          this.waitFor(() => say("tool.no_server_answer"), kSessionWithinMs);
        break;
    }
  }

  private waitFor(complaint: Words, withinMs: number): void {
    window.clearTimeout(this.patience);
    this.patience = window.setTimeout(() => {
      if (this.hold !== "asking") return;
      this.host.publish({op: "release"});
      this.end(complaint);
    }, withinMs);
  }

  /// Pointer, wheel and keys over the picture move the tool while it is held, else the camera.
  /// @param controls  the camera's
  listenTo(canvas: HTMLCanvasElement, controls: {enabled: boolean}): void {
    // In the capture phase, before the camera's own listeners.
    const first = {capture: true, passive: false};
    const down = (event: PointerEvent): void => {
      const isTools = this.hold === "holding" && !event.altKey;
      controls.enabled = !isTools;
      if (!isTools) return;
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, {x: event.clientX, y: event.clientY});
      this.turning = event.button === 2 || event.shiftKey;
    };
    const up = (event: PointerEvent): void => {
      this.pointers.delete(event.pointerId);
      controls.enabled = true;
    };
    canvas.addEventListener("pointerdown", down, first);
    canvas.addEventListener("pointermove", (event) => this.pointerMove(event), first);
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("wheel", (event) => this.wheel(event), first);
    canvas.addEventListener("keydown", (event) => this.key(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  private pointerMove(event: PointerEvent): void {
    const last = this.pointers.get(event.pointerId);
    if (!last || this.hold !== "holding") return;
    const here = {x: event.clientX, y: event.clientY};
    const dx = here.x - last.x;
    const dy = here.y - last.y;
    const other = [...this.pointers].find(([id]) => id !== event.pointerId)?.[1];
    this.pointers.set(event.pointerId, here);
    if (other) {
      this.pinch(last, here, other);
    } else if (this.turning || event.shiftKey) {
      this.move((pose, view, centroid) => turn(pose, view, centroid, dx, dy));
    } else {
      this.move((pose, view) => slide(pose, view, dx, dy));
    }
  }

  private wheel(event: WheelEvent): void {
    const nowMs = performance.now();
    const isPushing = nowMs - this.pushedMs < kWheelPausesMs;
    if (this.hold !== "holding" && !isPushing) return;
    this.pushedMs = nowMs;
    event.preventDefault();
    if (this.hold !== "holding") return event.stopImmediatePropagation();
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 * event.deltaY : event.deltaY;
    // Wheel away from the user: push.
    this.move((pose, view) =>
      push(pose, view, -pixels * kWheelMetresPerPixel * view.metresPerPixel),
    );
  }

  private key(event: KeyboardEvent): void {
    const step = kSteps[event.key];
    if (!step || this.hold !== "holding" || event.ctrlKey || event.altKey || event.metaKey) return;
    event.preventDefault();
    const [dx, dy, dz] = step;
    if (event.shiftKey) {
      this.move((pose, view, centroid) => turn(pose, view, centroid, dx, dy));
    } else {
      this.move((pose, view) => push(slide(pose, view, dx, dy), view, dz * view.metresPerPixel));
    }
  }

  /// Two fingers: spread pulls, pinch pushes, rotation rolls, moving both sideways turns.
  private pinch(last: Point, here: Point, other: Point): void {
    const before = {x: last.x - other.x, y: last.y - other.y};
    const after = {x: here.x - other.x, y: here.y - other.y};
    const apart = Math.hypot(after.x, after.y) - Math.hypot(before.x, before.y);
    const around = Math.atan2(
      before.x * after.y - before.y * after.x,
      before.x * after.x + before.y * after.y,
    );
    const dx = (here.x - last.x) / 2; // of the point between the fingers
    const dy = (here.y - last.y) / 2;
    this.move((pose, view, centroid) =>
      turn(
        roll(push(pose, view, -apart * view.metresPerPixel), view, centroid, around),
        view,
        centroid,
        dx,
        dy,
      ),
    );
  }

  private begin(): void {
    this.hold = "holding";
    window.clearTimeout(this.patience);
    // Nothing is sent before the hand moves: the tool stays where its station begins.
    this.pose = undefined;
    this.sent = undefined;
  }

  private end(message: Words): void {
    this.hold = "none";
    this.expects = false;
    this.message = message;
    this.pose = undefined;
    this.pointers.clear();
    window.clearTimeout(this.patience);
    window.clearTimeout(this.timer);
    this.timer = undefined;
    this.host.changed();
  }

  private move(by: (pose: Pose, view: ViewFrame, centroid: Vec3) => Pose): void {
    const tool = this.host.tool(this.station, this.scene, this.tool);
    if (!tool) return;
    const {pose, touches, centroid} = tool;
    const from = this.pose ?? pose;
    const moved = by(from, this.host.viewFrame(from.p), centroid);
    this.pose = touches ? leash(moved, pose, kReachM) : moved;
    this.send();
  }

  /// A bur has begun or ceased to turn.
  pedalled(): void {
    this.send();
  }

  /// Sends at once, or when the last pose is old enough: the newest pose is always sent.
  private send(): void {
    const waitMs = this.lastSentMs + kSendEveryMs - performance.now();
    if (waitMs > 0) {
      this.timer ??= window.setTimeout(() => {
        this.timer = undefined;
        this.send();
      }, waitMs);
      return;
    }
    const {pose, sent} = this;
    const still = this.host.still();
    if (!pose || (sent?.still === still && samePose(sent.pose, pose))) return;
    this.lastSentMs = performance.now();
    this.sent = {pose, still};
    this.host.publish({op: "pose", p: pose.p, q: pose.q, ...(still ? {still} : {})});
  }
}

interface Point {
  readonly x: number;
  readonly y: number;
}
