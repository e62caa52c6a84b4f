import type {SolidBlock} from "../protocol/messages";
import type {Vec3} from "../base/pose";

/// Grid points along a side of a block.
export const kSide = 8;
/// Steps per grid spacing in a block's coordinates, and their offset (scenes/grid/surface_code.h).
export const kSteps = 21;
export const kBeforeSteps = 2 * kSteps;

const kMostBlocks = 1 << 24;
const kMostVertices = 5916; // per block, as there
const kMostTriangles = 6144;
const kNarrow = 256; // vertices

/// The grid of blocks of a solid.
export interface Lattice {
  readonly origin: Vec3; // in the object's frame [m]
  readonly spacingM: number;
  readonly blocks: Vec3;
}

/// The remaining part of a solid in one block; immutable.
export interface Block {
  readonly change: number;
  readonly cut: boolean; // the object's mesh is no longer its surface there
  readonly vertices: Uint8Array; // x y z, x y z, ... [steps]
  readonly triangles: Uint16Array; // counter-clockwise, seen from outside
  readonly materials: Uint8Array; // one for all triangles, or one for each
  readonly removedMm3: readonly number[]; // of each material
}

/// An object that burs have cut: the newest version of each block, received in any order.
export class Solid {
  readonly blocks = new Map<number, Block>();
  version = 0; // changes whenever something has changed

  constructor(readonly lattice: Lattice) {}

  set(number: number, block: Block): void {
    if ((this.blocks.get(number)?.change ?? 0) > block.change) return;
    this.blocks.set(number, block);
    this.version += 1;
  }

  /// What burs have removed of a material.
  removedMm3(material: number): number {
    let sum = 0;
    for (const {removedMm3} of this.blocks.values()) sum += removedMm3[material] ?? 0;
    return sum;
  }

  undo(lastChange: number): void {
    for (const [number, {change}] of this.blocks) {
      if (change <= lastChange) this.blocks.delete(number);
    }
    this.version += 1;
  }

  /// @param use  (block, its number, its offset from the block in the middle [blocks])
  forAround(number: number, use: (block: Block, number: number, by: Vec3) => void): void {
    const [nx, ny, nz] = this.lattice.blocks;
    const [x, y, z] = [number % nx, Math.floor(number / nx) % ny, Math.floor(number / nx / ny)];
    for (let k = Math.max(0, z - 1); k <= Math.min(nz - 1, z + 1); k++) {
      for (let j = Math.max(0, y - 1); j <= Math.min(ny - 1, y + 1); j++) {
        for (let i = Math.max(0, x - 1); i <= Math.min(nx - 1, x + 1); i++) {
          const other = (k * ny + j) * nx + i;
          const block = other === number ? undefined : this.blocks.get(other);
          if (block) use(block, other, [i - x, j - y, k - z]);
        }
      }
    }
  }
}

/// Returns the position of a block's origin [m].
export function beginOf({origin, spacingM, blocks}: Lattice, number: number): Vec3 {
  const [nx, ny] = blocks;
  const side = kSide * spacingM;
  return [
    origin[0] + side * (number % nx),
    origin[1] + side * (Math.floor(number / nx) % ny),
    origin[2] + side * Math.floor(number / nx / ny),
  ];
}

export const countOf = ({blocks}: Lattice): number => blocks[0] * blocks[1] * blocks[2];

/// Returns undefined if the message has no valid lattice.
export function latticeOf({originM: origin, spacingM, blocks}: SolidBlock): Lattice | undefined {
  const lattice = {origin, spacingM, blocks};
  const count = countOf(lattice);
  const isOne = [...origin, spacingM].every(Number.isFinite) && spacingM > 0;
  return isOne && count > 0 && count <= kMostBlocks ? lattice : undefined;
}

/// Returns undefined if the bytes are damaged.
export function readBlock({change, cut, surface, removedMm3}: SolidBlock): Block | undefined {
  const words = new DataView(surface.buffer, surface.byteOffset, surface.byteLength);
  if (words.byteLength < 6) return undefined;
  const [count, quads, others] = [0, 2, 4].map((at) =>
    words.getUint16(at, true),
  ) as unknown as Vec3;
  const faces = quads + others;
  const triangles = new Uint16Array(3 * (2 * quads + others));
  if (count > kMostVertices || triangles.length > 3 * kMostTriangles) return undefined;
  if (count === 0) {
    const none = new Uint8Array();
    const isBare = faces === 0 && words.byteLength === 6;
    const bare = {change, cut, vertices: none, triangles, materials: none, removedMm3};
    return isBare ? bare : undefined;
  }
  const wide = count <= kNarrow ? 1 : 2;
  const begin = 6 + 3 * count;
  const end = begin + wide * (4 * quads + 3 * others);
  const left = words.byteLength - end;
  if (left !== 1 && left !== faces) return undefined;
  const corner = (nth: number): number =>
    wide === 1 ? words.getUint8(begin + nth) : words.getUint16(begin + 2 * nth, true);
  for (let quad = 0; quad < quads; quad++) {
    const at = [0, 1, 2, 3].map((k) => corner(4 * quad + k)) as [number, number, number, number];
    triangles.set([at[0], at[1], at[2], at[0], at[2], at[3]], 6 * quad);
  }
  for (let i = 0; i < 3 * others; i++) triangles[6 * quads + i] = corner(4 * quads + i);
  if (triangles.some((vertex) => vertex >= count)) return undefined;
  const materials = surface.slice(end);
  const ofTriangles =
    left === 1
      ? materials
      : Uint8Array.from({length: triangles.length / 3}, (_, t) =>
          t < 2 * quads ? materials[t >> 1]! : materials[t - quads]!,
        );
  const vertices = surface.slice(6, begin);
  return {change, cut, vertices, triangles, materials: ofTriangles, removedMm3};
}
