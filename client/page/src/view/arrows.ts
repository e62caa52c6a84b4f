import {
  type BufferGeometry,
  Color,
  ConeGeometry,
  CylinderGeometry,
  Group,
  Mesh,
  MeshBasicMaterial,
  Quaternion,
  SphereGeometry,
  TorusGeometry,
  Vector3,
} from "three";

import {norm, scale, subtract, type Vec3} from "../base/pose";
import type {ContactPoint} from "../protocol/messages";

/// Force and torque as arrows that show through everything, each with a halo for contrast; the tool
/// in turn shows through them.  Lengths have one scale, up to the longest that fits the picture, so
/// that the contacts' arrows add up to the force's.
const kLengthPerNewton = 0.4; // share of the initial view's radius
const kLongest = 0.6;
const kOpacity = 0.72;
const kHaloOpacity = 0.3;
const kWeakestN = 0.01;
const kUp = new Vector3(0, 1, 0);

const kHalo = [true, false] as const;

/// A part of an arrow, with its halo.
class Haloed {
  readonly group = new Group();
  private readonly colours: MeshBasicMaterial[] = [];
  private readonly halos: MeshBasicMaterial[] = [];

  protected add(geometry: BufferGeometry, order: number, isHalo: boolean): Mesh {
    const material = new MeshBasicMaterial({
      depthTest: false,
      depthWrite: false,
      transparent: true,
      opacity: isHalo ? kHaloOpacity : kOpacity,
    });
    (isHalo ? this.halos : this.colours).push(material);
    const mesh = new Mesh(geometry, material);
    mesh.renderOrder = order + (isHalo ? 0 : 1);
    this.group.add(mesh);
    return mesh;
  }

  paint(colour: Color, halo: Color): void {
    for (const material of this.colours) material.color.copy(colour);
    for (const material of this.halos) material.color.copy(halo);
  }
}

const kShaft = new CylinderGeometry(1, 1, 1, 20).translate(0, 0.5, 0);
const kHead = new ConeGeometry(1, 1, 28).translate(0, 0.5, 0);
const kBall = new SphereGeometry(1, 20, 14);

class Arrow extends Haloed {
  private readonly parts: {shaft: Mesh; head: Mesh; grown: number}[];

  /// @param thickness  of the shaft, as a share of the initial view's radius
  constructor(
    private readonly thickness: number,
    order: number,
  ) {
    super();
    this.parts = kHalo.map((isHalo) => ({
      shaft: this.add(kShaft, order, isHalo),
      head: this.add(kHead, order, isHalo),
      grown: isHalo ? 0.45 : 0,
    }));
  }

  set(from: Vec3, vectorN: Vec3, radiusM: number): void {
    const newtons = norm(vectorN);
    this.group.visible = newtons >= kWeakestN;
    if (!this.group.visible) return;
    this.group.position.set(...from);
    const direction = new Vector3(...vectorN).divideScalar(newtons);
    this.group.quaternion.copy(new Quaternion().setFromUnitVectors(kUp, direction));
    const length = radiusM * Math.min(kLongest, kLengthPerNewton * newtons);
    const thick = radiusM * this.thickness;
    const head = Math.min(5 * thick, 0.6 * length);
    for (const {shaft, head: cone, grown} of this.parts) {
      const rim = grown * thick;
      shaft.scale.set(thick + rim, Math.max(1e-6, length - head), thick + rim);
      cone.position.y = length - head - rim;
      cone.scale.set(0.45 * head + 1.6 * rim, head + 3.2 * rim, 0.45 * head + 1.6 * rim);
    }
  }
}

/// Of the torque's circle, as a share of that radius: it grows with the torque, and its diameter is
/// at most the length of the arrow of the smallest force that a hand notices, a third of a newton.
const kRingAtOne = 0.09; // if the torque is that of a newton at that radius
const kLeastRing = 0.05;
const kLargestRing = 0.066;
// distance from the base of the force's arrow to the circle's centre, per radius
const kRingGap = 1.35;

/// Three quarters of a circle about the torque's axis, right-handed.  It stands behind the base of
/// the force's arrow, so that neither hides the other.
class TorqueArrow extends Haloed {
  constructor(order: number) {
    super();
    const arc = 1.5 * Math.PI;
    for (const isHalo of kHalo) {
      this.add(new TorusGeometry(1, isHalo ? 0.15 : 0.1, 12, 64, arc), order, isHalo);
      const grown = isHalo ? 0.05 : 0;
      const cone = new ConeGeometry(0.28 + grown, 0.6 + 2 * grown, 24).translate(0, 0.15, 0);
      const head = this.add(cone, order, isHalo);
      head.position.set(Math.cos(arc), Math.sin(arc), 0);
      head.rotation.z = arc; // +y of the cone along the tangent
    }
  }

  /// Its area is proportional to the torque.
  set(at: Vec3, forceN: Vec3, torqueNm: Vec3, radiusM: number): void {
    const share = norm(torqueNm) / Math.max(1e-9, radiusM);
    this.group.visible = share > 0.003;
    if (!this.group.visible) return;
    const ringM =
      radiusM * Math.min(kLargestRing, Math.max(kLeastRing, kRingAtOne * Math.sqrt(share)));
    const newtons = norm(forceN);
    const backM = newtons < kWeakestN ? 0 : kRingGap * ringM;
    this.group.position.set(...subtract(at, scale(forceN, backM / Math.max(1e-9, newtons))));
    const axis = new Vector3(...torqueNm).normalize();
    this.group.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), axis));
    this.group.scale.setScalar(ringM);
  }
}

const kMostContacts = 16;

/// All drawings of a tool's forces.
export class ForceMarks {
  readonly group = new Group();
  private readonly force = new Arrow(0.01, 30);
  private readonly torque = new TorqueArrow(20);
  private readonly contacts: {arrow: Arrow; dot: Mesh<SphereGeometry, MeshBasicMaterial>}[] = [];

  constructor() {
    for (let i = 0; i < kMostContacts; i++) {
      const arrow = new Arrow(0.005, 40);
      const dot = new Mesh(
        kBall,
        new MeshBasicMaterial({depthTest: false, depthWrite: false, transparent: true}),
      );
      dot.renderOrder = 42;
      this.contacts.push({arrow, dot});
      this.group.add(arrow.group, dot);
    }
    this.group.add(this.torque.group, this.force.group);
  }

  paint(colours: {force: Color; torque: Color; contact: Color; halo: Color}): void {
    this.force.paint(colours.force, colours.halo);
    this.torque.paint(colours.torque, colours.halo);
    for (const {arrow, dot} of this.contacts) {
      arrow.paint(colours.contact, colours.halo);
      dot.material.color.copy(colours.contact);
    }
  }

  set(
    at: Vec3,
    forceN: Vec3,
    torqueNm: Vec3,
    points: readonly ContactPoint[],
    radiusM: number,
  ): void {
    this.force.set(at, forceN, radiusM);
    this.torque.set(at, forceN, torqueNm, radiusM);
    this.contacts.forEach(({arrow, dot}, i) => {
      const point = points[i];
      dot.visible = point !== undefined;
      arrow.group.visible = false;
      if (!point) return;
      // A single contact's arrow would equal the force's.
      if (points.length > 1) arrow.set(point.positionM, point.forceN, radiusM);
      dot.position.set(...point.positionM);
      dot.scale.setScalar(radiusM * (0.007 + 0.008 * Math.min(1, Math.sqrt(norm(point.forceN)))));
    });
  }
}
