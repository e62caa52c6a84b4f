import type {Group} from "three";

import type {Body, SceneModel} from "../model/bundle";
import {angleBetween, norm, pointOf, type Pose, subtract, type Vec3} from "../base/pose";
import {middleOfPush} from "../model/touched";
import type {ToolState} from "../protocol/messages";
import {ForceMarks} from "./arrows";
import {BodyMesh, place, type SurfaceCache} from "./body_mesh";
import {Ghost} from "./ghost";
import type {Palette} from "./palette";

/// A tool in the picture: its body, the ghosts of the hand and of the guide, and its forces.
export class ToolView {
  readonly body: BodyMesh;
  readonly groups: readonly Group[];
  pose: Pose;
  isMet = false; // its pose has been received
  private readonly ghost: Ghost;
  private readonly lead: Ghost;
  private readonly marks = new ForceMarks();

  /// @param end  its working end, in its frame.   @param pose  the present one
  constructor(
    tool: Body,
    scene: SceneModel,
    index: number,
    cache: SurfaceCache,
    private readonly end: Vec3,
    pose: Pose | undefined,
  ) {
    this.pose = pose ?? tool.pose;
    this.body = new BodyMesh(tool, scene, "tool", index, cache);
    const {geometry} = this.body.mesh;
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

  paint(palette: Palette): void {
    this.body.paint(palette);
    this.ghost.paint(palette.ghost);
    this.lead.paint(palette.ink);
    this.marks.paint(palette);
  }

  /// @param radiusM  of the initial view
  set({graphic, haptic, forceN, torqueNm, points}: ToolState, radiusM: number): void {
    this.pose = graphic;
    place(this.body.group, graphic);
    place(this.ghost.group, haptic);
    const {centroid, radiusM: leverM} = this.body.body.geometry;
    const centre = pointOf(graphic, centroid);
    const apartM = norm(subtract(pointOf(haptic, centroid), centre));
    this.ghost.setDistance(apartM + leverM * angleBetween(haptic.q, graphic.q));
    // Where the objects push: a long tool's centroid is often outside the picture.
    this.marks.set(middleOfPush(points) ?? centre, forceN, torqueNm, points, radiusM);
  }

  /// Shows where the hand should move it; undefined: nowhere.
  setLead(pose: Pose | undefined): void {
    if (pose) place(this.lead.group, pose);
    this.lead.setDistance(pose ? 1 : 0);
  }

  dispose(): void {
    for (const part of [this.body, this.ghost, this.lead]) part.dispose();
  }
}
