import {say} from "../messages/say";
import type {SceneModel} from "../model/bundle";
import type {Pose} from "../model/pose";
import {looksTheSame} from "../model/pose_track";
import {type Drawn, PictureQuality, qualityOf} from "../model/quality";
import type {Remains} from "../model/remains";
import {pictureWords} from "../model/words";
import type {Station} from "../model/world";
import type {ToolState} from "../protocol/messages";
import {element} from "../ui/elements";
import {QualityPick} from "../ui/quality_pick";
import {readPalette} from "../view/palette";
import {drawsBySoftware} from "../view/renderer";
import {type Cost, SceneView} from "../view/scene_view";
import {ToolPointer} from "../view/tool_pointer";
import {nowS} from "./now";

/// The first pictures upload meshes and compile shaders: once, and not what a picture costs.
const kWarmUp = 3;

/// Whom a frame shows: asked for in each.
export interface PictureHost {
  /// Who moved a tool of the scene last.
  mover(tool: string): Station | undefined;
  /// The station whose figures are shown.
  station(): Station | undefined;
  /// The tool that this page may take, or has.
  ownTool(): string;
  /// Where its hand is to go, while it is led.
  lead(now: number): Pose | undefined;
}

export interface PictureProbe {
  firstPictureMs: number | undefined; // since the page was asked for
  pictures: number;
  scriptMs: number; // of a picture on average, without the card's time
  triangles: number;
  costs: {still: Cost; moving: Cost}; // of what stands still, when it was drawn last, and of the rest
  drawnAnew: number; // times that what stands still was drawn
  quality: {rest: string; motion: string};
}

/// The picture of the scene that is shown: drawn when something changes, and only then.
export class Picture {
  readonly canvas = element("view", HTMLCanvasElement);
  readonly view: SceneView;
  private readonly quality: PictureQuality;
  private readonly qualityPick: QualityPick;
  private readonly toolPointer: ToolPointer;
  private firstPictureMs: number | undefined;
  private pictures = 0;
  private drawnAnew = 0;
  private scriptMs = 0; // of all pictures that count
  private tools: SceneModel["tools"] = [];
  private drawn: ToolState[] = []; // of each tool
  private frameAsked = false;
  private dirty = true;
  private leads = false;
  private before: {drawn: Drawn; atMs: number} | undefined; // in the frame before
  private settling: number | undefined; // timer

  constructor(private readonly host: PictureHost) {
    const bySoftware = drawsBySoftware();
    const fixed = qualityOf(new URLSearchParams(location.search).get("quality") ?? "");
    this.quality = new PictureQuality(bySoftware, fixed);
    const below = element("below", HTMLDivElement);
    this.toolPointer = new ToolPointer(element("tool-pointer", HTMLButtonElement), below, () =>
      this.lookAtAll(),
    );
    this.view = new SceneView(
      this.canvas,
      element("labels", HTMLDivElement),
      below,
      readPalette(),
      this.quality,
      !bySoftware || fixed === "full", // smoothed edges take a third of a processor's time
      matchMedia("(prefers-reduced-motion: reduce)").matches,
      () => this.askFrame(),
    );
    this.qualityPick = new QualityPick(this.quality, () => this.view.resize());
    new ResizeObserver(() => this.view.resize()).observe(this.canvas);
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
  /// @param poseOf   of a tool, as far as that is known
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
    const words = model ? pictureWords(model) : say("stage.view");
    this.canvas.setAttribute("aria-label", words);
  }

  lookAtAll(): void {
    this.view.lookAtAll();
    this.askFrame();
  }

  /// Something has changed that a picture shows.
  askFrame(): void {
    this.dirty = true;
    this.wake();
  }

  /// Something may have changed: the frame finds out, and draws only then.
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
      this.wake(); // it tells by when the browser was ready for another one
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

  /// True while there are frames that the picture has not reached.
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

  /// True while there is somebody to lead.
  private showLead(now: number): boolean {
    const lead = this.host.lead(now);
    if (lead || this.leads) {
      this.view.setLead(this.host.ownTool(), lead);
      this.dirty = true;
    }
    this.leads = lead !== undefined;
    return this.leads;
  }

  private pointToTool(): void {
    const own = this.host.ownTool();
    const index = Math.max(
      0,
      this.tools.findIndex(({name}) => name === own),
    );
    const end = this.view.draws ? this.view.endOf(index) : undefined;
    this.toolPointer.update(
      this.view.camera.eye,
      end,
      this.tools[index]?.name ?? say("tools.tool"),
    );
  }

  /// @return whether the eye follows the tool from now on
  followOrNot(): boolean {
    const on = !this.view.camera.following;
    this.view.camera.follow(on);
    const state = this.host.station()?.shown(nowS());
    if (on && state) this.view.camera.toolAt(state.graphic.p);
    this.askFrame();
    return on;
  }

  /// Where the frame before drew, how long it took tells how well pictures can be drawn.
  private judge(atMs: number): void {
    const {before} = this;
    this.before = undefined;
    if (!before || !this.quality.took(before.drawn, atMs - before.atMs)) return;
    this.view.resize();
    this.qualityPick.show();
  }

  /// What was drawn in haste, while the eye moved, is drawn well once it rests.
  private settleLater(nowMs: number): void {
    window.clearTimeout(this.settling);
    const inMs = this.view.settlesInMs(nowMs);
    if (inMs !== undefined) this.settling = window.setTimeout(() => this.askFrame(), inMs);
  }
}
