import {say} from "../messages/say";
import type {SceneModel} from "../model/bundle";
import type {Pose} from "../base/pose";
import {looksTheSame} from "../model/pose_track";
import {type Drawn, kQualities, PictureQuality, qualityOf, qualityWords} from "../model/quality";
import type {Remains} from "../model/remains";
import {pictureWords} from "../model/words";
import type {Station} from "../model/station";
import type {ToolState} from "../protocol/messages";
import {rememberInAddress} from "../ui/address";
import {element, onPress, option, setTextOf} from "../ui/elements";
import {followLanguage, setWords} from "../ui/spoken";
import {readPalette} from "../view/palette";
import {drawsBySoftware} from "../view/renderer";
import {type Cost, SceneView} from "../view/scene_view";
import {nowS} from "./now";

/// The first pictures upload meshes and compile shaders, so they tell nothing about the cost
/// of a picture.
const kWarmUp = 3;
/// The picture's share that counts as free, however much covers it.
const kLeastRoom = 0.2;

const kHalfPointer = 22; // half the size of the arrow to the tool [pixels], as in stage.css

/// What a frame shows; queried in each frame.
export interface PictureHost {
  /// Who moved a tool of the scene last.
  mover(tool: string): Station | undefined;
  /// The station whose figures are shown.
  station(): Station | undefined;
  /// The tool that this page may take or holds.
  ownTool(): string;
  /// Where the hand should go, while it is guided.
  lead(now: number): Pose | undefined;
}

export interface PictureProbe {
  firstPictureMs: number | undefined; // since the page was requested
  pictures: number;
  scriptMs: number; // mean per picture, without the graphics card's time
  triangles: number;
  costs: {still: Cost; moving: Cost}; // of the static layer when last drawn, and of the rest
  drawnAnew: number; // number of times the static layer was drawn
  quality: {rest: string; motion: string};
}

/// The picture of the shown scene, drawn only when something changes.
export class Picture {
  readonly canvas = element("view", HTMLCanvasElement);
  readonly view: SceneView;
  private readonly above = element("above", HTMLDivElement);
  private readonly below = element("below", HTMLDivElement);
  private readonly quality: PictureQuality;
  private readonly qualityPick = element("quality", HTMLSelectElement);
  private readonly toolPointer = onPress("tool-pointer", () => this.lookAtAll());
  private firstPictureMs: number | undefined;
  private pictures = 0;
  private drawnAnew = 0;
  private scriptMs = 0; // of all pictures that count
  private tools: SceneModel["tools"] = [];
  private drawn: ToolState[] = []; // state of each tool
  private frameAsked = false;
  private dirty = true;
  private leads = false;
  private before: {drawn: Drawn; atMs: number} | undefined; // the previous frame
  private settling: number | undefined; // timer

  constructor(private readonly host: PictureHost) {
    const bySoftware = drawsBySoftware();
    const fixed = qualityOf(new URLSearchParams(location.search).get("quality") ?? "");
    this.quality = new PictureQuality(bySoftware, fixed);
    this.view = new SceneView(
      this.canvas,
      element("labels", HTMLDivElement),
      this.below,
      readPalette(),
      this.quality,
      !bySoftware || fixed === "full", // antialiasing takes a third of a processor's time
      matchMedia("(prefers-reduced-motion: reduce)").matches,
      () => this.askFrame(),
    );
    this.offerQualities();
    const resized = new ResizeObserver(() => this.resize());
    for (const one of [this.canvas, this.above, this.below]) resized.observe(one);
    this.resize();
  }

  get probe(): PictureProbe {
    const {firstPictureMs, pictures, drawnAnew} = this;
    const scriptMs = this.scriptMs / Math.max(1, pictures - kWarmUp);
    const {costs} = this.view;
    const triangles = costs.still.triangles + costs.moving.triangles;
    const quality = this.quality.names;
    return {firstPictureMs, pictures, scriptMs, triangles, costs, drawnAnew, quality};
  }

  /// @param remains  what is left of it
  /// @param poseOf   pose of a tool, if known
  setScene(
    model: SceneModel | undefined,
    remains: Remains,
    poseOf: (tool: string) => Pose | undefined,
  ): void {
    this.tools = model?.tools ?? [];
    this.drawn = [];
    this.quality.restart();
    this.view.setScene(model, remains, poseOf);
    this.view.resize();
    setWords(this.canvas, "ariaLabel", () => (model ? pictureWords(model) : say("stage.view")));
  }

  /// What is looked at is shown beside what covers the picture for long: not the banner.
  private resize(): void {
    const {above, below, canvas} = this;
    const strips = above.querySelectorAll<HTMLElement>(":scope > :not(.banner, [hidden])");
    const bottoms = [...strips].map((one) => above.offsetTop + one.offsetTop + one.offsetHeight);
    const top = Math.max(0, ...bottoms);
    const height = Math.max(below.offsetTop - top, kLeastRoom * canvas.clientHeight);
    // For the legend, which stands on them.
    canvas.parentElement!.style.setProperty(
      "--below",
      `${canvas.clientHeight - below.offsetTop}px`,
    );
    this.view.uncovered = {width: canvas.clientWidth, top, height};
    this.view.resize();
  }

  lookAtAll(): void {
    this.view.lookAtAll();
    this.askFrame();
  }

  /// Something visible has changed.
  askFrame(): void {
    this.dirty = true;
    this.wake();
  }

  /// Something may have changed: the next frame checks, and draws only if so.
  wake(): void {
    if (this.frameAsked) return;
    this.frameAsked = true;
    requestAnimationFrame((atMs) => this.frame(atMs));
  }

  private frame(atMs: number): void {
    const startMs = performance.now();
    this.frameAsked = false;
    this.judge(atMs);
    const led = this.showLead(startMs / 1000);
    const catchingUp = this.moveTools(startMs / 1000) || led;
    this.dirty = this.view.camera.controls.update() || this.dirty;
    if (this.dirty) {
      this.dirty = false;
      const drawn = this.view.render(startMs);
      this.pointToTool();
      this.before = {drawn, atMs};
      if (this.view.draws && !this.view.isEmpty) this.count(drawn, startMs);
      this.settleLater(startMs);
      this.wake(); // its start shows when the browser was ready for another frame
    }
    if (catchingUp) this.wake();
  }

  private count(drawn: Drawn, startMs: number): void {
    const nowMs = performance.now();
    this.firstPictureMs ??= nowMs;
    this.pictures += 1;
    this.drawnAnew += drawn === "tools" ? 0 : 1;
    if (this.pictures > kWarmUp) this.scriptMs += nowMs - startMs;
  }

  /// Returns whether there are frames that the picture has not reached.
  private moveTools(now: number): boolean {
    let catchingUp = false;
    this.tools.forEach(({name}, i) => {
      const mover = this.host.mover(name);
      const state = mover?.shown(now);
      if (!mover || !state) return;
      catchingUp = mover.isCatchingUp(now) || catchingUp;
      if (looksTheSame(state, this.drawn[i])) return;
      this.view.setTool(name, state);
      if (mover === this.host.station()) this.view.camera.toolAt(state.graphic.p);
      this.drawn[i] = state;
      this.dirty = true;
    });
    return catchingUp;
  }

  /// Returns whether a hand is being guided.
  private showLead(now: number): boolean {
    const lead = this.host.lead(now);
    if (lead || this.leads) {
      this.view.setLead(this.host.ownTool(), lead);
      this.dirty = true;
    }
    this.leads = lead !== undefined;
    return this.leads;
  }

  /// An arrow at the picture's edge if the tool is outside; pressing it brings the tool back.
  private pointToTool(): void {
    const own = this.host.ownTool();
    const index = Math.max(
      0,
      this.tools.findIndex(({name}) => name === own),
    );
    const {view, toolPointer: button} = this;
    const end = view.draws ? view.endOf(index) : undefined;
    const place = end && view.camera.edgePlace(end, view.uncovered, kHalfPointer);
    button.hidden = place === undefined;
    if (!place) return;
    const tool = this.tools[index]?.name ?? say("tools.tool");
    const words = say("stage.out_of_picture", {tool});
    if (button.title !== words) button.title = button.ariaLabel = words;
    const [x, y] = [place.x - kHalfPointer, place.y - kHalfPointer];
    button.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) rotate(${place.angle.toFixed(3)}rad)`;
  }

  /// The reader may fix the pictures' quality.
  private offerQualities(): void {
    const {qualityPick: pick, quality} = this;
    pick.add(option(() => say("quality.by_pace"), ""));
    for (const name of kQualities) pick.add(option(() => say(`quality.always_${name}`), name));
    pick.value = quality.fixed ?? "";
    pick.addEventListener("change", () => {
      quality.fixed = qualityOf(pick.value);
      rememberInAddress("quality", pick.value);
      this.showQuality();
      this.view.resize();
    });
    followLanguage(() => this.showQuality());
    this.showQuality();
  }
  private showQuality(): void {
    setTextOf("quality-words", qualityWords(this.quality));
  }

  /// @return whether the camera follows the tool from now on
  followOrNot(): boolean {
    const on = !this.view.camera.following;
    this.view.camera.follow(on);
    const state = this.host.station()?.shown(nowS());
    if (on && state) this.view.camera.toolAt(state.graphic.p);
    this.askFrame();
    return on;
  }

  /// If the previous frame drew, its duration decides about the quality.
  private judge(atMs: number): void {
    const {before} = this;
    this.before = undefined;
    if (!before || !this.quality.took(before.drawn, atMs - before.atMs)) return;
    this.view.resize();
    this.showQuality();
  }

  /// A picture of reduced quality, drawn while the camera moved, is redrawn once it rests.
  private settleLater(nowMs: number): void {
    window.clearTimeout(this.settling);
    const inMs = this.view.settlesInMs(nowMs);
    if (inMs !== undefined) this.settling = window.setTimeout(() => this.askFrame(), inMs);
  }
}
