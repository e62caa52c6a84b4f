import {Vector3} from "three";

import type {Vec3} from "./pose";
import {beginOf, kSide, type Lattice} from "./solid";
import type {Surface} from "./surface";

/// A place on a mesh: vertices of it, and their shares.
export interface SkinPlace {
  readonly vertices: Vec3;
  readonly shares: Vec3;
}

/// Farther from the mesh than this a place is not of it, or where it faces elsewhere [h].
const kNear = 0.2;
const kSameWay = 0.8;
/// Shares of a place in the next triangle, which rounding may have put there.
const kBeside = -0.02;
/// A block's triangles reach so far beyond it [h].
const kBesideH = 2;
/// Its part of the mesh is looked for in that of so many blocks along each axis.
const kWide = 8;

/// What a mesh looked like before it was cut.
export class Skin {
  private readonly planes: Float32Array; // of each triangle: normal, and product with its places [m]
  private readonly boxes: Float32Array; // low and high [m]
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

  /// @param block  that the place belongs to, or lies beside
  /// @param p, n   that of a vertex, from `at` on
  at(block: number, p: Float32Array, n: Float32Array, at: number): SkinPlace | undefined {
    const {planes} = this;
    const within = kNear * this.lattice.spacingM;
    const [x, y, z] = [p[at]!, p[at + 1]!, p[at + 2]!];
    for (const t of this.trianglesIn(block)) {
      const [nx, ny, nz] = [planes[4 * t]!, planes[4 * t + 1]!, planes[4 * t + 2]!];
      if (Math.abs(nx * x + ny * y + nz * z - planes[4 * t + 3]!) > within) continue;
      if (nx * n[at]! + ny * n[at + 1]! + nz * n[at + 2]! < kSameWay) continue;
      const shares = this.sharesOf(t, x, y, z);
      if (Math.min(...shares) < kBeside) continue;
      const {index} = this.surface;
      return {vertices: [index[3 * t]!, index[3 * t + 1]!, index[3 * t + 2]!], shares};
    }
    return undefined;
  }

  /// Of a place that is projected onto a triangle.
  private sharesOf(t: number, x: number, y: number, z: number): Vec3 {
    const {index, positions} = this.surface;
    const [a, b, c] = [3 * index[3 * t]!, 3 * index[3 * t + 1]!, 3 * index[3 * t + 2]!];
    const [n0, n1, n2] = this.planes.subarray(4 * t, 4 * t + 3) as unknown as Vec3;
    /// Twice the area that an edge and the place span, seen along the normal.
    const area = (i: number, j: number): number => {
      const [ex, ey, ez] = [
        positions[j]! - positions[i]!,
        positions[j + 1]! - positions[i + 1]!,
        positions[j + 2]! - positions[i + 2]!,
      ];
      const [px, py, pz] = [x - positions[i]!, y - positions[i + 1]!, z - positions[i + 2]!];
      return n0 * (ey * pz - ez * py) + n1 * (ez * px - ex * pz) + n2 * (ex * py - ey * px);
    };
    const areas = [area(b, c), area(c, a), area(a, b)] as const;
    const all = areas[0] + areas[1] + areas[2];
    return [areas[0] / all, areas[1] / all, areas[2] / all];
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

  /// Those that a cube may have to do with, and what lies a little beside it.
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
