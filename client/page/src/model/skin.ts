import {Vector3} from "three";

import type {Vec3} from "../base/pose";
import {beginOf, kSide, type Lattice} from "./solid";
import type {Surface} from "./surface";

/// A point farther from the mesh than this does not belong to it [h]: one row of triangles below
/// a shallow rim.
const kNear = 0.2;
/// Nor does one whose normal differs more than this (cosine).
const kSameWay = 0.8;
/// Tolerance of barycentric coordinates, for a point that rounding has put into the next triangle.
const kBeside = -0.02;
/// A block's triangles, and those touching them, extend this far beyond it [h].
const kBesideH = 4;
/// The mesh's triangles near a block are looked up in cubes of this many blocks per side.
const kWide = 8;

/// The mesh before it was cut.
export class Skin {
  // for each triangle: normal, and its product with the corners [m]
  private readonly planes: Float32Array;
  private readonly boxes: Float32Array; // bounds, low and high [m]
  private readonly inBlock = new Map<number, readonly number[]>();
  private readonly inWide = new Map<string, readonly number[]>();

  constructor(
    private readonly surface: Surface,
    private readonly lattice: Lattice,
  ) {
    const {positions, index} = surface;
    this.planes = new Float32Array((4 * index.length) / 3);
    this.boxes = new Float32Array(2 * index.length);
    const [a, b, c, normal] = [new Vector3(), new Vector3(), new Vector3(), new Vector3()];
    for (let t = 0; t < index.length / 3; t++) {
      [a, b, c].forEach((corner, i) => corner.fromArray(positions, 3 * index[3 * t + i]!));
      normal.subVectors(b, a).cross(c.clone().sub(a)).normalize();
      this.planes.set([...normal.toArray(), normal.dot(a)], 4 * t);
      const high = a.clone().max(b).max(c);
      this.boxes.set([...a.min(b).min(c).toArray(), ...high.toArray()], 6 * t);
    }
  }

  /// Returns whether a point is on the mesh.  @param block  contains the point, or lies beside it
  isAt(block: number, x: number, y: number, z: number): boolean {
    return this.find(block, x, y, z, 0, 0, 0, -1) >= 0;
  }

  /// Returns the triangle that contains a point and faces that way (unit vector), or -1.
  at(block: number, x: number, y: number, z: number, nx: number, ny: number, nz: number): number {
    return this.find(block, x, y, z, nx, ny, nz, kSameWay);
  }

  private find(
    block: number,
    x: number,
    y: number,
    z: number,
    nx: number,
    ny: number,
    nz: number,
    alike: number,
  ): number {
    const {planes} = this;
    const within = kNear * this.lattice.spacingM;
    for (const t of this.trianglesIn(block)) {
      const px = planes[4 * t]!;
      const py = planes[4 * t + 1]!;
      const pz = planes[4 * t + 2]!;
      if (Math.abs(px * x + py * y + pz * z - planes[4 * t + 3]!) > within) continue;
      if (px * nx + py * ny + pz * nz < alike) continue;
      const [a, b, c] = this.sharesOf(t, x, y, z);
      if (a >= kBeside && b >= kBeside && c >= kBeside) return t;
    }
    return -1;
  }

  /// Returns the barycentric coordinates of a point projected onto a triangle.
  sharesOf(t: number, x: number, y: number, z: number): Vec3 {
    const {index} = this.surface;
    const a = 3 * index[3 * t]!;
    const b = 3 * index[3 * t + 1]!;
    const c = 3 * index[3 * t + 2]!;
    const atA = this.area(t, b, c, x, y, z);
    const atB = this.area(t, c, a, x, y, z);
    const atC = this.area(t, a, b, x, y, z);
    const all = atA + atB + atC;
    return [atA / all, atB / all, atC / all];
  }

  /// Twice the area spanned by an edge and the point, projected along the normal.
  private area(t: number, i: number, j: number, x: number, y: number, z: number): number {
    const {planes} = this;
    const {positions} = this.surface;
    const ex = positions[j]! - positions[i]!;
    const ey = positions[j + 1]! - positions[i + 1]!;
    const ez = positions[j + 2]! - positions[i + 2]!;
    const px = x - positions[i]!;
    const py = y - positions[i + 1]!;
    const pz = z - positions[i + 2]!;
    return (
      planes[4 * t]! * (ey * pz - ez * py) +
      planes[4 * t + 1]! * (ez * px - ex * pz) +
      planes[4 * t + 2]! * (ex * py - ey * px)
    );
  }

  private trianglesIn(block: number): readonly number[] {
    let inside = this.inBlock.get(block);
    if (inside) return inside;
    const side = kSide * this.lattice.spacingM;
    const begin = beginOf(this.lattice, block);
    const at = begin.map((x, i) => Math.round((x - this.lattice.origin[i]!) / side));
    const wideAt = at.map((n) => Math.floor(n / kWide));
    let wide = this.inWide.get(wideAt.join());
    if (!wide) {
      const all = Array.from(this.boxes.subarray(0, this.boxes.length / 6).keys());
      const from = wideAt.map((n, i) => this.lattice.origin[i]! + kWide * side * n);
      this.inWide.set(wideAt.join(), (wide = this.among(all, from, kWide * side)));
    }
    this.inBlock.set(block, (inside = this.among(wide, begin, side)));
    return inside;
  }

  /// Returns the triangles that may be in or near a cube.
  private among(triangles: readonly number[], begin: readonly number[], side: number): number[] {
    const {boxes} = this;
    const beside = kBesideH * this.lattice.spacingM;
    const axes = [0, 1, 2];
    return triangles.filter((t) =>
      axes.every(
        (i) =>
          boxes[6 * t + i]! <= begin[i]! + side + beside &&
          boxes[6 * t + 3 + i]! >= begin[i]! - beside,
      ),
    );
  }
}
