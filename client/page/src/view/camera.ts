import {MathUtils, PerspectiveCamera, Spherical, Vector3} from "three";
import {OrbitControls} from "three/examples/jsm/controls/OrbitControls.js";

import type {FirstSight} from "../model/bundle";
import {add, scale, subtract, type Vec3} from "../base/pose";
import {edgePlace, type EdgePlace, type Room} from "../model/edge_place";
import type {ViewFrame} from "../mouse/tool_motion";

const kFieldOfViewDeg = 32;
/// A picture smaller than this shows less around the tool, instead of all so small [pixels];
/// and at least this share of it, so that the middle of the work is in it.
const kUsualRoom = 560;
const kNearest = 0.48;

/// The camera: orbits its target, follows the tool if asked to, and can be reset.
export class Camera {
  readonly eye = new PerspectiveCamera(kFieldOfViewDeg);
  readonly controls: OrbitControls;
  following = false;
  untouched = true; // nobody has moved it since it was framed
  /// The part of the canvas that nothing covers; the target is in its middle.
  room: Room = {width: 1, top: 0, height: 1};
  private lastTool: Vector3 | undefined;
  private sight: FirstSight | undefined; // framed last

  constructor(
    private readonly canvas: HTMLCanvasElement,
    calm: boolean,
    moved: () => void,
  ) {
    this.controls = new OrbitControls(this.eye, canvas);
    this.controls.enableDamping = !calm;
    this.controls.dampingFactor = 0.12;
    this.controls.rotateSpeed = 0.8;
    this.controls.addEventListener("change", moved);
    this.controls.addEventListener("start", () => (this.untouched = false));
  }

  /// Sets the view that a reset restores.
  frame(sight: FirstSight): void {
    this.sight = sight;
    const {width, height} = this.room;
    const {from, end} = sight;
    const nearer = MathUtils.clamp(Math.min(width, height) / kUsualRoom, kNearest, 1);
    const radiusM = nearer * sight.radiusM;
    const centre = end ? add(end, scale(subtract(sight.centre, end), nearer)) : sight.centre;
    this.controls.minDistance = 0.3 * radiusM;
    this.controls.maxDistance = 20 * radiusM;
    this.untouched = true;
    this.lastTool = undefined;
    const share = Math.min(width, height) / Math.max(1, this.canvas.clientHeight);
    const half = Math.atan(Math.tan(MathUtils.degToRad(kFieldOfViewDeg / 2)) * share);
    const distance = (1.08 * radiusM) / Math.sin(half);
    this.controls.target.set(...centre);
    this.eye.position
      .set(...from)
      .setLength(distance)
      .add(this.controls.target);
    this.eye.near = distance / 200;
    this.eye.far = 40 * distance;
    this.eye.updateProjectionMatrix();
    this.controls.update();
  }

  /// The canvas, or what covers it, has another size.
  fit(room: Room): void {
    this.room = room;
    const {clientWidth: width, clientHeight: height} = this.canvas;
    const up = 0.5 * height - (room.top + 0.5 * room.height);
    this.eye.setViewOffset(width, height, 0, up, width, height);
    if (this.sight && this.untouched && !this.following) this.frame(this.sight);
  }

  /// Moves along with the tool, if it is to be followed.
  toolAt(position: Vec3): void {
    const here = new Vector3(...position);
    if (this.following) {
      const move = here.clone().sub(this.lastTool ?? this.controls.target);
      this.controls.target.add(move);
      this.eye.position.add(move);
    }
    this.lastTool = this.following ? here : undefined;
  }

  follow(on: boolean): void {
    this.following = on;
    this.lastTool = undefined;
  }

  /// Orbits the target or moves nearer, by keys.
  nudge(azimuth: number, polar: number, zoom: number): void {
    this.untouched = false;
    const {target, minDistance, maxDistance} = this.controls;
    const at = new Spherical().setFromVector3(this.eye.position.clone().sub(target));
    at.radius = MathUtils.clamp(zoom * at.radius, minDistance, maxDistance);
    at.phi = MathUtils.clamp(at.phi + polar, 0.05, Math.PI - 0.05);
    at.theta += azimuth;
    this.eye.position.setFromSpherical(at).add(target);
    this.controls.update();
  }

  /// Where an arrow to a point outside the room is; undefined: the point is in the room.
  edgePlace(point: Vec3, room: Room, inset: number): EdgePlace | undefined {
    const at = new Vector3(...point).applyMatrix4(this.eye.matrixWorldInverse).toArray();
    const tan = Math.tan(MathUtils.degToRad(0.5 * kFieldOfViewDeg));
    return edgePlace(at, tan, room, this.canvas.clientHeight, inset);
  }

  viewFrame(at: Vec3): ViewFrame {
    const right = new Vector3();
    const up = new Vector3();
    const back = new Vector3();
    this.eye.updateMatrixWorld();
    this.eye.matrixWorld.extractBasis(right, up, back);
    const depth = new Vector3(...at).sub(this.eye.position).dot(back) * -1;
    const height = 2 * Math.max(depth, 1e-3) * Math.tan(MathUtils.degToRad(kFieldOfViewDeg / 2));
    return {
      right: right.toArray(),
      up: up.toArray(),
      forward: back.negate().toArray(),
      metresPerPixel: height / Math.max(1, this.canvas.clientHeight),
    };
  }
}
