import {nameOf} from "../model/names";
import {say} from "../messages/say";
import type {SceneModel} from "../model/bundle";
import {burOf} from "../model/drilled";
import type {Station} from "../model/station";
import type {World} from "../model/world";
import {MouseDevice, type MouseHost} from "../mouse/mouse_device";
import type {ToolState} from "../protocol/messages";
import {element, onPress, setOptions, setText} from "../ui/elements";
import type {Notice} from "../ui/notice";
import {PedalButton} from "../ui/pedal_button";
import type {Choice} from "./choice";
import type {GatewayLink} from "./gateway_link";
import {nowS} from "./now";
import type {Picture} from "./picture";
import type {SceneStore} from "./scene_store";

/// The tool held by the reader: taken by button or key, moved by pointer and keys.
export class ToolHold {
  readonly mouse: MouseDevice;
  private readonly button = onPress("take", () => this.takeOrRelease());
  private readonly pedal = new PedalButton(() => this.mouse.pedalled());
  private readonly toolPick = element("tool", HTMLSelectElement);

  /// @param mayTake  returns whether this page may take a tool
  /// @param keeps    returns whether the reader is to be asked before the tool is given back; asks
  constructor(
    private readonly world: World,
    private readonly choice: Choice,
    private readonly scenes: SceneStore,
    private readonly link: GatewayLink,
    private readonly picture: Picture,
    private readonly notice: Notice,
    private readonly mayTake: () => boolean,
    private readonly keeps: () => boolean,
    private readonly isInTrial: () => boolean,
  ) {
    const {canvas, view} = picture;
    this.mouse = new MouseDevice({
      publish: (message) => link.publish("mouse", message),
      changed: () => this.show(),
      still: () => this.holdsBur && !this.pedal.turns,
      viewFrame: (at) => view.camera.viewFrame(at),
      tool: (station, scene, tool) => this.whereIs(station, scene, tool),
    });
    // The tool's keys take precedence: while it is held, arrows move it and not the camera.
    this.mouse.listenTo(canvas, view.camera.controls);
    this.toolPick.addEventListener("change", () => this.change());
    // Otherwise a closed page would keep its tool; a trial's waits for the page to come back.
    addEventListener("pagehide", () => {
      if (!this.isInTrial()) this.mouse.release();
    });
  }

  /// Keys, for listenForKeys.
  readonly keys: Readonly<Record<string, () => void>> = {
    m: () => this.takeOrRelease(),
    Escape: () => this.giveBack(),
  };

  /// Whether it holds or requests a tool.
  get isBusy(): boolean {
    return this.mouse.hold !== "none";
  }
  /// The station of this page's mouse; empty: none.
  get station(): string {
    return this.isBusy ? this.mouse.station : "";
  }
  /// The tool to be taken, or taken.
  get tool(): string {
    return this.toolPick.value;
  }

  /// What the server last said of this page's tool.
  get ownState(): ToolState | undefined {
    return this.world.stations.get(this.station)?.own;
  }
  /// Whether this page holds a bur, and with its pedal pressed.
  get burTurns(): boolean {
    return this.holdsBur && this.pedal.turns;
  }
  private get holdsBur(): boolean {
    const {hold, scene, tool} = this.mouse;
    return hold === "holding" && burOf(this.scenes.model(scene), tool) !== undefined;
  }

  /// Shows the controls for taking a tool, or the hint, only if this page may.
  offer(may: boolean): void {
    for (const part of document.querySelectorAll<HTMLElement>(".of-mouse")) part.hidden = !may;
  }

  showTools(tools: SceneModel["tools"]): void {
    const options = tools.map(({name}) => ({value: name, text: name}));
    const [first] = options;
    setOptions(
      this.toolPick,
      options,
      this.toolPick.value || (first?.value ?? ""),
      say("tools.no_tool"),
    );
    if (first && this.toolPick.selectedIndex < 0) this.toolPick.selectedIndex = 0;
    element("tool-pick", HTMLLabelElement).hidden = options.length < 2;
    this.show();
  }

  show(): void {
    const {hold} = this.mouse;
    const message = this.mouse.takeMessage();
    const holding = hold === "holding";
    this.picture.canvas.classList.toggle("holding", holding);
    this.button.classList.toggle("holding", holding);
    document.body.classList.toggle("holds", holding);
    this.button.disabled = hold === "none" && !this.isSceneHere();
    if (holding) this.toolPick.value = this.mouse.tool; // also a trial's
    const words = {holding: "tool.give_back", asking: "tool.cancel", none: "tool.take"} as const;
    setText(this.button, () => say(words[hold]));
    this.picture.view.camera.controls.enableZoom = !holding;
    const isTouched = matchMedia("(pointer: coarse)").matches;
    const how = (): string => say(isTouched ? "tool.how_by_touch" : "tool.how");
    const pedal = (): string => say(isTouched ? "tool.pedal_by_touch" : "tool.pedal_how");
    const {holdsBur} = this;
    const help = (): string =>
      holdsBur ? say("list.sentences", {first: pedal(), second: how()}) : how();
    this.pedal.show(holdsBur);
    this.mouse.pedalled();
    const asking = (): string => say("tool.asking");
    if (hold === "none" && message !== "") {
      const {scene} = this.choice;
      const whileSo = (): boolean => !this.isBusy && this.choice.scene === scene;
      this.notice.say(message, {alarm: true, whileSo});
    }
    this.notice.rest(hold === "none" ? "" : message || (holding ? help : asking));
    this.notice.update(true);
    if (holding) this.picture.canvas.focus({preventScroll: true});
  }

  private isSceneHere(): boolean {
    return this.scenes.model(this.choice.scene) !== undefined;
  }

  private takeOrRelease(): void {
    if (!this.mayTake()) return;
    if (!this.isSceneHere()) {
      const whileSo = (): boolean => !this.isSceneHere();
      this.notice.say(() => say("tool.none_yet"), {whileSo});
      return;
    }
    if (this.isBusy) return this.giveBack();
    const {scene} = this.choice;
    const holder = this.world.holderOf(scene, this.tool);
    // A tool that does not move may be free, or have been this page's own: the server decides.
    if (holder?.isMoving(nowS()) && holder.id !== this.mouse.station) {
      this.sayWhoHolds(holder, scene, this.tool);
      return;
    }
    this.choice.stay(); // also after the tool is released
    this.mouse.take(scene, this.tool);
  }

  /// Another tool was chosen: who holds one changes it.
  private change(): void {
    if (!this.isBusy || this.isInTrial()) return;
    this.mouse.release();
    this.takeOrRelease();
  }

  private giveBack(): void {
    if (this.isBusy && !this.keeps()) this.mouse.release();
  }

  private sayWhoHolds(holder: Station, scene: string, tool: string): void {
    const whileSo = (): boolean =>
      this.choice.scene === scene &&
      holder.isMoving(nowS()) &&
      this.world.holderOf(scene, tool) === holder;
    const who = (): string => say("tool.held", {station: nameOf(holder.id), tool});
    if (!this.link.may.operate) {
      const words = (): string =>
        say("list.sentences", {first: who(), second: say("tool.free_later")});
      this.notice.say(words, {alarm: true, whileSo});
      return;
    }
    const run = (): void => {
      this.link.publish("operate", {op: "take_back", station: holder.id});
      this.notice.say(() => say("tool.taking_back"));
    };
    this.notice.say(who, {
      alarm: true,
      whileSo,
      action: {text: () => say("tool.take_it_back"), run},
    });
  }

  private whereIs(station: string, scene: string, tool: string): ReturnType<MouseHost["tool"]> {
    const body = this.scenes.model(scene)?.tools.find(({name}) => name === tool);
    const centroid = body?.geometry.centroid ?? [0, 0, 0];
    const state = this.world.stations.get(station)?.own;
    const pose = state?.graphic ?? body?.pose;
    return pose && {pose, touches: (state?.contacts ?? 0) > 0, centroid};
  }
}
