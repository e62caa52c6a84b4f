import {DirectionalLight, Group, HemisphereLight, Scene, type WebGLRenderer} from "three";

import type {SceneModel} from "../model/bundle";
import type {Room} from "../model/edge_place";
import {endOf, firstSight, workOf} from "../model/first_sight";
import {kIdentity, type Pose, type Vec3} from "../base/pose";
import {type Drawn, kDetails, type PictureQuality} from "../model/quality";
import type {Remains} from "../model/remains";
import type {ToolState} from "../protocol/messages";
import {BodyMesh, place, SurfaceCache} from "./body_mesh";
import {Camera} from "./camera";
import {CanvasSize} from "./canvas_size";
import {kToLamp} from "./depth_cues";
import {ToothLabels} from "./labels";
import type {Palette} from "./palette";
import {makeRenderer} from "./renderer";
import {levelsOf, SphereClouds} from "./sphere_cloud";
import {StillLayer} from "./still_layer";
import {ToolView} from "./tool_view";

/// What a picture costs a graphics card.
export interface Cost {
  triangles: number;
  calls: number;
}

/// The picture.  Draws only when asked to; whoever changes something calls `changed`.  Static
/// objects are redrawn only if the camera moved or they have changed.
export class SceneView {
  readonly camera: Camera;
  private readonly renderer: WebGLRenderer | undefined;
  private readonly scene = new Scene();
  private readonly still = new Group();
  private readonly moving = new Group();
  private readonly layer: StillLayer | undefined;
  private readonly hemisphere = new HemisphereLight();
  private model: SceneModel | undefined;
  private objects: BodyMesh[] = [];
  private tools: ToolView[] = [];
  private moved: Group[] = []; // of objects that move together
  private readonly clouds = new SphereClouds();
  private sphereLevel: number | undefined;
  private radiusM = 0.1; // of the initial view
  private sightM = 0.1; // radius of the work area
  private coarserAsked = false;
  private readonly size: CanvasSize;
  /// The part of the canvas that nothing covers.
  uncovered: Room = {width: 1, top: 0, height: 1};
  /// Of the static layer when last drawn, and of what is drawn in each picture.
  readonly costs = {still: {triangles: 0, calls: 0}, moving: {triangles: 0, calls: 0}};
  private remains: Remains | undefined;
  readonly labels: ToothLabels;

  constructor(
    canvas: HTMLCanvasElement,
    labelSheet: HTMLElement,
    buttons: HTMLElement,
    private palette: Palette,
    private readonly quality: PictureQuality,
    antialias: boolean,
    calm: boolean,
    private readonly changed: () => void,
  ) {
    this.renderer = makeRenderer(canvas, antialias);
    this.size = new CanvasSize(canvas, quality);
    this.labels = new ToothLabels(labelSheet, buttons);
    this.camera = new Camera(canvas, calm, changed);
    const key = new DirectionalLight(0xffffff, 1.9);
    key.position.copy(kToLamp);
    const fill = new DirectionalLight(0xffffff, 0.75);
    fill.position.set(-0.9, 0.1, 0.5);
    // Lights fixed to the camera: every side that is looked at is lit the same way.
    this.camera.eye.add(key, key.target, fill, fill.target);
    this.scene.add(this.camera.eye, this.hemisphere, this.still, this.moving);
    if (this.renderer) {
      this.layer = new StillLayer(this.renderer);
      this.still.add(this.layer.background);
      this.moving.add(this.layer.copy);
    }
    // A graphics card that has lost its data gets it again.
    canvas.addEventListener("webglcontextrestored", () => this.restartLayer());
    this.paint(palette);
    this.resize();
  }

  /// @param remains  what is left of it
  /// @param toolNow  present pose of a tool, if known
  setScene(
    model: SceneModel | undefined,
    remains: Remains | undefined,
    toolNow: (name: string) => Pose | undefined,
  ): void {
    this.clear();
    this.model = model;
    this.remains = remains;
    this.restartLayer(); // the old layer shows another scene
    if (!model) return;
    const cache = new SurfaceCache();
    const work = workOf(model);
    this.layer?.cues.setWork(work);
    this.sightM = work.radiusM;
    this.radiusM = firstSight(model, []).radiusM;
    this.objects = model.objects.map((body, i) => new BodyMesh(body, model, "object", i, cache));
    this.tools = model.tools.map(
      (tool, i) =>
        new ToolView(tool, model, i, cache, endOf(tool, work), work.radiusM, toolNow(tool.name)),
    );
    for (const object of this.objects) {
      const moved = object.body.moved > 0 ? this.movedGroup(object.body.moved - 1) : undefined;
      (moved ?? this.still).add(object.group);
      (moved ?? this.moving).add(object.over);
    }
    for (const {groups} of this.tools) this.moving.add(...groups);
    this.labels.setObjects(this.objects);
    this.paint(this.palette);
    this.updateRemains();
    this.makeClouds();
    this.lookAtAll();
  }

  /// The initial view, with the work area and the tools where they are now.
  lookAtAll(): void {
    const poses = this.tools.map(({pose}) => pose);
    if (this.model) this.camera.frame(firstSight(this.model, poses));
  }

  /// Returns the working end of a tool, in W.
  endOf(tool: number): Vec3 | undefined {
    return this.tools[tool]?.endInWorld;
  }

  paint(palette: Palette): void {
    this.palette = palette;
    this.hemisphere.color.copy(palette.sky);
    this.hemisphere.groundColor.copy(palette.ground);
    this.hemisphere.intensity = 1.6;
    for (const part of [...this.objects, ...this.tools, this.clouds]) part.paint(palette);
    this.layer?.paint(palette);
    this.changed();
  }

  updateRemains(): void {
    if (!this.remains) return;
    let any = false;
    this.objects.forEach((object, i) => {
      any = object.setCut(this.remains!.solidOf(i)) || any;
    });
    if (any) this.changeLayer();
  }

  /// Number of levels; the last one is the leaves.
  get sphereLevels(): number {
    return levelsOf([...(this.model?.objects ?? []), ...(this.model?.tools ?? [])]);
  }

  /// @param level  from 0, coarse; undefined: no spheres
  setSphereLevel(level: number | undefined): void {
    if (level === this.sphereLevel) return;
    this.sphereLevel = level;
    this.makeClouds();
    this.restartLayer();
  }

  setTool(name: string, state: ToolState): void {
    const tool = this.tools.find((one) => one.name === name);
    if (!tool) return;
    const isFirst = !tool.isMet && this.camera.untouched;
    tool.set(state, this.radiusM);
    this.moved.forEach((group, i) => place(group, state.moved[i] ?? kIdentity));
    if (!isFirst) return;
    tool.isMet = true; // until now only its start pose was known
    this.lookAtAll();
  }

  /// Shows where a hand should move a tool, as a transparent tool; undefined: nowhere.
  setLead(name: string, pose: Pose | undefined): void {
    for (const tool of this.tools) tool.setLead(tool.name === name ? pose : undefined);
  }

  /// The canvas, or its pixels at rest, may have another size: the next picture uses it.
  resize(): void {
    this.size.mayChange();
    this.changed();
  }

  /// @return what was redrawn
  render(nowMs: number): Drawn {
    const resized = this.size.hasChanged();
    if (resized) this.layer?.restart();
    if (resized || this.uncovered !== this.camera.room) this.camera.fit(this.uncovered);
    const drawn = this.draw(nowMs);
    this.labels.update(
      this.camera.eye,
      this.tools.map(({body}) => body),
    );
    return drawn;
  }

  /// Returns when a better picture of the same view is due; undefined: it is at its best.
  settlesInMs(nowMs: number): number | undefined {
    return this.layer?.settlesInMs(nowMs);
  }

  /// False if the browser has no WebGL: everything except the picture works.
  get draws(): boolean {
    return this.renderer !== undefined;
  }
  get isEmpty(): boolean {
    return this.model === undefined;
  }

  private draw(nowMs: number): Drawn {
    const {renderer, layer, scene, costs} = this;
    const {eye} = this.camera;
    if (!renderer || !layer) return "else";
    const {inMotion} = this.quality;
    if (inMotion.detail > 0) void this.makeCoarser();
    const info = (): Cost => ({
      triangles: renderer.info.render.triangles,
      calls: renderer.info.render.calls,
    });
    const step = layer.next(eye, nowMs, inMotion);
    const hurried = step.sheet === "hurried";
    this.size.apply(renderer, hurried ? inMotion.canvas : this.quality.share);
    if (step.anew) {
      this.show(this.still);
      for (const object of this.objects) object.catchUp();
      renderer.info.reset();
      this.setDetail(hurried ? inMotion.detail : 0);
      layer.draw(scene, eye, step.sheet, hurried ? inMotion.share / inMotion.canvas : 1);
      this.setDetail(0);
      costs.still = info();
    }
    this.show(this.moving);
    renderer.info.reset();
    layer.cues.light(this.quality.cues, eye, this.tools[0]?.nearEnd ?? []);
    renderer.render(scene, eye);
    costs.moving = info();
    return step.drawn;
  }

  private setDetail(detail: number): void {
    for (const object of this.objects) object.setDetail(detail);
  }

  private show(part: Group): void {
    this.still.visible = part === this.still;
    this.moving.visible = part === this.moving;
  }

  private changeLayer(): void {
    this.layer?.change();
    this.changed();
  }
  private restartLayer(): void {
    this.layer?.restart();
    this.changed();
  }

  /// One after the other, with pictures in between.
  private async makeCoarser(): Promise<void> {
    if (this.coarserAsked) return;
    this.coarserAsked = true;
    const objects = this.objects;
    const distances = kDetails.map((share) => share * this.sightM);
    for (const object of objects) {
      if (this.objects !== objects) return; // they belong to another scene
      await object.makeCoarser(distances);
      await new Promise((resolve) => setTimeout(resolve));
    }
  }

  /// Like tools, they are drawn in each picture.
  private movedGroup(number: number): Group {
    while (this.moved.length <= number) {
      const group = new Group();
      this.moved.push(group);
      this.moving.add(group);
    }
    return this.moved[number]!;
  }

  private makeClouds(): void {
    const tools = this.tools.map(({body}) => body);
    this.clouds.show(this.objects, tools, this.sphereLevel, this.palette);
  }

  private clear(): void {
    this.clouds.clear();
    for (const object of this.objects) {
      object.group.removeFromParent();
      object.over.removeFromParent();
      object.dispose();
    }
    this.moving.remove(...this.moved);
    this.moved = [];
    for (const tool of this.tools) {
      this.moving.remove(...tool.groups);
      tool.dispose();
    }
    this.objects = [];
    this.tools = [];
    this.coarserAsked = false;
    this.labels.setObjects([]);
  }
}
