import {DirectionalLight, Group, HemisphereLight, Scene, type WebGLRenderer} from "three";

import type {SceneModel} from "../model/bundle";
import {endOf, firstSight, workOf} from "../model/first_sight";
import {angleBetween, norm, pointOf, type Pose, subtract, type Vec3} from "../model/pose";
import {type Drawn, kDetails, type PictureQuality} from "../model/quality";
import type {Remains} from "../model/remains";
import {middleOfPush} from "../model/touched";
import type {ToolState} from "../protocol/messages";
import {ForceMarks} from "./arrows";
import {BodyMesh, place, SurfaceCache} from "./body_mesh";
import {Camera} from "./camera";
import {Ghost} from "./ghost";
import {ToothLabels} from "./labels";
import type {Palette} from "./palette";
import {makeRenderer} from "./renderer";
import {SphereCloud} from "./sphere_cloud";
import {StillLayer} from "./still_layer";

/// Phones with three pixels per point would draw nine times as much without visible gain.
const kMostPixelsPerPoint = 2;

interface ToolView {
  readonly body: BodyMesh;
  readonly ghost: Ghost;
  readonly lead: Ghost;
  readonly marks: ForceMarks;
}

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
  private clouds: {cloud: SphereCloud; body: BodyMesh}[] = [];
  private sphereLevel: number | undefined;
  private ends: Vec3[] = []; // working ends of the tools, in their frames
  private poses: Pose[] = []; // of the tools
  private readonly met = new Set<number>(); // the tools whose pose is known
  private radiusM = 0.1; // of the initial view
  private sightM = 0.1; // radius of the work area
  private coarserAsked = false;
  private sized = "";
  // [points], [points], pixels per point and side
  private screen = {width: 1, height: 1, pixels: 1};
  private canvasShare = 0; // share of the screen's pixels; 0: not sized yet
  private mayHaveResized = true;
  /// Of the static layer when last drawn, and of what is drawn in each picture.
  readonly costs = {still: {triangles: 0, calls: 0}, moving: {triangles: 0, calls: 0}};
  private remains: Remains | undefined;
  readonly labels: ToothLabels;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    labelSheet: HTMLElement,
    buttons: HTMLElement,
    private palette: Palette,
    private readonly quality: PictureQuality,
    antialias: boolean,
    calm: boolean,
    private readonly changed: () => void,
  ) {
    this.renderer = makeRenderer(canvas, antialias);
    this.labels = new ToothLabels(labelSheet, buttons);
    this.camera = new Camera(canvas, calm, changed);
    const key = new DirectionalLight(0xffffff, 1.9);
    key.position.set(0.5, 0.9, 0.8);
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
    this.objects = model.objects.map((body, i) => new BodyMesh(body, model, "object", i, cache));
    this.tools = model.tools.map((body, i) => {
      const solid = new BodyMesh(body, model, "tool", i, cache);
      const [ghost, lead] = [new Ghost(solid.mesh.geometry), new Ghost(solid.mesh.geometry)];
      return {body: solid, ghost, lead, marks: new ForceMarks()};
    });
    for (const object of this.objects) {
      this.still.add(object.group);
      this.moving.add(object.over);
    }
    this.labels.setObjects(this.objects);
    for (const {body, ghost, lead, marks} of this.tools) {
      this.moving.add(body.group, ghost.group, lead.group, marks.group);
      ghost.setDistance(0);
      lead.setDistance(0);
      marks.set([0, 0, 0], [0, 0, 0], [0, 0, 0], [], 1);
    }
    this.paint(this.palette);
    this.updateRemains();
    this.makeClouds();
    this.radiusM = firstSight(model, []).radiusM;
    const work = workOf(model);
    this.sightM = work.radiusM;
    this.ends = model.tools.map((tool) => endOf(tool, work));
    this.poses = model.tools.map(({name, pose}) => toolNow(name) ?? pose);
    this.met.clear();
    this.lookAtAll();
  }

  /// The initial view, with the work area and the tools where they are now.
  lookAtAll(): void {
    if (this.model) this.camera.frame(firstSight(this.model, this.poses));
  }

  /// Returns the working end of a tool, in W.
  endOf(tool: number): Vec3 | undefined {
    const [pose, end] = [this.poses[tool], this.ends[tool]];
    return pose && end && pointOf(pose, end);
  }

  paint(palette: Palette): void {
    this.palette = palette;
    this.hemisphere.color.copy(palette.sky);
    this.hemisphere.groundColor.copy(palette.ground);
    this.hemisphere.intensity = 1.6;
    for (const object of this.objects) object.paint(palette);
    this.tools.forEach(({body, ghost, lead, marks}) => {
      body.paint(palette);
      ghost.paint(palette.ghost);
      lead.paint(palette.ink);
      marks.paint(palette);
    });
    this.paintClouds();
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
    const bodies = [...(this.model?.objects ?? []), ...(this.model?.tools ?? [])];
    return Math.max(0, ...bodies.map((body) => body.geometry.levels.length));
  }

  /// @param level  from 0, coarse; undefined: no spheres
  setSphereLevel(level: number | undefined): void {
    if (level === this.sphereLevel) return;
    this.sphereLevel = level;
    this.makeClouds();
    this.restartLayer();
  }

  setTool(name: string, state: ToolState): void {
    const index = this.tools.findIndex(({body}) => body.body.name === name);
    const tool = this.tools[index];
    if (!tool) return;
    this.poses[index] = state.graphic;
    if (!this.met.has(index) && this.camera.untouched) {
      this.met.add(index); // until now only its start pose was known
      this.lookAtAll();
    }
    place(tool.body.group, state.graphic);
    place(tool.ghost.group, state.haptic);
    const {centroid, radiusM} = tool.body.body.geometry;
    const apart =
      norm(subtract(pointOf(state.haptic, centroid), pointOf(state.graphic, centroid))) +
      radiusM * angleBetween(state.haptic.q, state.graphic.q);
    tool.ghost.setDistance(apart);
    // Where the objects push: a long tool's centroid is often outside the picture.
    const at = middleOfPush(state.points) ?? pointOf(state.graphic, centroid);
    tool.marks.set(at, state.forceN, state.torqueNm, state.points, this.radiusM);
  }

  /// Shows where a hand should move a tool, as a transparent tool; undefined: nowhere.
  setLead(name: string, pose: Pose | undefined): void {
    for (const {body, lead} of this.tools) {
      const isLed = pose !== undefined && body.body.name === name;
      if (isLed) place(lead.group, pose);
      lead.setDistance(isLed ? 1 : 0);
    }
  }

  /// The canvas, or its pixels at rest, may have another size: the next picture uses it.
  resize(): void {
    this.mayHaveResized = true;
    this.changed();
  }

  private fit(): void {
    if (!this.mayHaveResized) return;
    this.mayHaveResized = false;
    const {clientWidth: width, clientHeight: height} = this.canvas;
    if (width === 0 || height === 0) return;
    const pixels = Math.min(devicePixelRatio, kMostPixelsPerPoint);
    const sized = `${width} ${height} ${pixels} ${this.quality.share}`;
    if (sized === this.sized) return;
    this.sized = sized;
    this.screen = {width, height, pixels};
    this.camera.resize(width / height);
    this.canvasShare = 0;
    this.layer?.restart();
  }

  /// Only together with a picture: resizing empties a canvas.
  /// @param share  of the screen's pixels, per side
  private sizeCanvas(renderer: WebGLRenderer, share: number): void {
    if (share === this.canvasShare) return;
    this.canvasShare = share;
    const {width, height, pixels} = this.screen;
    renderer.setDrawingBufferSize(width, height, share * pixels);
  }

  /// @return what was redrawn
  render(nowMs: number): Drawn {
    this.fit();
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
    this.sizeCanvas(renderer, hurried ? inMotion.canvas : this.quality.share);
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

  private makeClouds(): void {
    for (const {cloud} of this.clouds) cloud.dispose();
    this.clouds = [];
    const bodies = [...this.objects, ...this.tools.map(({body}) => body)];
    for (const body of bodies) body.mesh.visible = true;
    if (this.sphereLevel === undefined) return;
    for (const body of bodies) {
      const {levels} = body.body.geometry;
      // Trees of one scene may differ in depth: the leaves are at the same end of the slider.
      const fromLeaves = this.sphereLevels - 1 - this.sphereLevel;
      const level = Math.max(0, levels.length - 1 - fromLeaves);
      const isLeaves = level === levels.length - 1;
      const isTool = !this.objects.includes(body);
      const parent = isTool || isLeaves ? body.group : body.over;
      const cloud = new SphereCloud(levels[level]!, parent, isLeaves);
      body.mesh.visible = !isLeaves;
      this.clouds.push({cloud, body});
    }
    this.paintClouds();
  }

  private paintClouds(): void {
    for (const {cloud, body} of this.clouds)
      cloud.paint(body.mesh.material.color, this.palette.ink);
  }

  private clear(): void {
    for (const {cloud} of this.clouds) cloud.dispose();
    this.clouds = [];
    for (const object of this.objects) {
      this.still.remove(object.group);
      this.moving.remove(object.over);
      object.dispose();
    }
    for (const {body, ghost, lead, marks} of this.tools) {
      this.moving.remove(body.group, ghost.group, lead.group, marks.group);
      body.dispose();
      ghost.dispose();
      lead.dispose();
    }
    this.objects = [];
    this.tools = [];
    this.coarserAsked = false;
    this.labels.setObjects([]);
  }
}
