import {
  type Color,
  CustomBlending,
  type Group,
  GreaterDepth,
  type Material,
  Mesh,
  OneFactor,
  Vector3,
  Vector4,
} from "three";

import type {Body, SceneModel} from "../model/bundle";
import {axisOf} from "../model/first_sight";
import {angleBetween, norm, pointOf, type Pose, subtract, type Vec3} from "../base/pose";
import {type NearEndBall, nearEndOf} from "../model/near_end";
import {middleOfPush} from "../model/touched";
import {burTurns, type ToolState} from "../protocol/messages";
import {ForceMarks} from "./arrows";
import {BodyMesh, place, type SurfaceCache} from "./body_mesh";
import {Ghost, makeRim} from "./ghost";
import type {Palette} from "./palette";
import {addFlutes} from "./flutes";
import {capEnds, clear} from "./shaft";

/// A tool in the picture: its body, the ghosts of the hand and of the guide, and its forces.
export class ToolView {
  readonly body: BodyMesh;
  readonly groups: readonly Group[];
  pose: Pose;
  isMet = false; // its pose has been received
  private readonly ghost: Ghost;
  private readonly lead: Ghost;
  private readonly marks = new ForceMarks();
  /// Where an object hides it.  Among what is opaque, so that it precedes the tool, which thus
  /// does not hide itself.
  private readonly through = makeRim({
    transparent: false,
    blending: CustomBlending,
    blendSrcAlpha: OneFactor,
    depthWrite: false,
    depthFunc: GreaterDepth,
  });
  private readonly shape: readonly NearEndBall[]; // of its end, in its frame
  private readonly turning = {value: 1}; // of a bur; 0: it stands still
  private veil: Material | undefined; // of its shaft where that hides its end

  /// @param end     its working end, in its frame
  /// @param sightM  radius of the work area
  /// @param pose    the present one
  constructor(
    tool: Body,
    scene: SceneModel,
    index: number,
    cache: SurfaceCache,
    private readonly end: Vec3,
    sightM: number,
    pose: Pose | undefined,
  ) {
    this.pose = pose ?? tool.pose;
    this.body = new BodyMesh(tool, scene, "tool", index, cache);
    const {geometry} = this.body.mesh;
    this.seeThrough(sightM);
    if (tool.bur) addFlutes(this.body.mesh.material, tool.bur, this.turning);
    this.shape = nearEndOf(tool, end, sightM);
    [this.ghost, this.lead] = [new Ghost(geometry), new Ghost(geometry)];
    this.groups = [this.body.group, this.ghost.group, this.lead.group, this.marks.group];
    this.ghost.setDistance(0);
    this.lead.setDistance(0);
    this.marks.set([0, 0, 0], [0, 0, 0], [0, 0, 0], [], 1);
  }

  get name(): string {
    return this.body.body.name;
  }
  /// Its working end, in W.
  get endInWorld(): Vec3 {
    return pointOf(this.pose, this.end);
  }

  /// The shape of its end, in W: centres and radii.
  get nearEnd(): Vector4[] {
    return this.shape.map(
      ({centre, radiusM}) => new Vector4(...pointOf(this.pose, centre), radiusM),
    );
  }

  paint(palette: Palette): void {
    this.body.paint(palette);
    (this.through.uniforms.uColour!.value as Color).copy(palette.tools[0]!);
    this.ghost.paint(palette.ghost);
    this.lead.paint(palette.ink);
    this.marks.paint(palette);
  }

  /// Its end is seen through the objects, through its shaft and, if the eye is within the shaft,
  /// through that.
  private seeThrough(sightM: number): void {
    const {body, mesh} = this.body;
    this.through.uniforms.uBody!.value = 0.35;
    this.through.uniforms.uRim!.value = 0.5;
    const through = new Mesh(mesh.geometry, this.through);
    through.renderOrder = -0.5; // after the objects
    mesh.add(through);
    capEnds(mesh.material);
    if (!axisOf(body)) return;
    const veil = (this.veil = this.body.makeMaterial());
    veil.color = mesh.material.color;
    veil.transparent = true;
    veil.depthWrite = false;
    clear(mesh.material, veil, new Vector3(...this.end), sightM);
    mesh.add(new Mesh(mesh.geometry, veil));
  }

  /// @param radiusM  of the initial view
  set(state: ToolState, radiusM: number): void {
    const {graphic, haptic, forceN, torqueNm, points} = state;
    this.pose = graphic;
    this.turning.value = burTurns(state) ? 1 : 0;
    place(this.body.group, graphic);
    place(this.ghost.group, haptic);
    const {centroid, radiusM: leverM} = this.body.body.geometry;
    const centre = pointOf(graphic, centroid);
    const apartM = norm(subtract(pointOf(haptic, centroid), centre));
    this.ghost.setDistance(apartM + leverM * angleBetween(haptic.q, graphic.q));
    // Where the objects push: a long tool's centroid is often outside the picture.  There a bur's
    // torque would hide what it cuts.
    const turnedNm: Vec3 = this.body.body.bur ? [0, 0, 0] : torqueNm;
    this.marks.set(middleOfPush(points) ?? centre, forceN, turnedNm, points, radiusM);
  }

  /// Shows where the hand should move it; undefined: nowhere.
  setLead(pose: Pose | undefined): void {
    if (pose) place(this.lead.group, pose);
    this.lead.setDistance(pose ? 1 : 0);
  }

  dispose(): void {
    for (const part of [this.body, this.ghost, this.lead, this.through, this.veil]) part?.dispose();
  }
}
