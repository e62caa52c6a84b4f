import type {Vec3} from "../base/pose";
import {beginOf, type Block, kBeforeSteps, kSide, kSteps, type Solid} from "./solid";
import type {Skin} from "./skin";
import {type Faces, makeSurface, measure, type Surface} from "./surface";

/// A block's triangles, and the neighbours' triangles that touch them.
export interface Patch {
  // x y z, x y z, ...: the block's first, then the neighbours' [steps]
  readonly vertices: readonly number[];
  readonly corners: readonly number[]; // vertex indices, in the same order
  readonly own: number; // number of the block's own corners
  readonly beside: number; // hash of the neighbours' part: it changes with them
}

export function makePatch(solid: Solid, number: number, block: Block): Patch {
  const known = placesOf(block);
  const vertices = Array.from(block.vertices);
  const corners = Array.from(block.triangles);
  const own = vertices.length / 3;
  const isOwn = (vertex: number): boolean => vertex >= 0 && vertex < own;
  let beside = 0;
  const count = (value: number): void => void (beside = Math.imul(beside ^ value, 0x01000193));
  solid.forAround(number, (other, _, by) => {
    const found = known.find(other, by);
    if (!found) return;
    const {triangles} = other;
    for (let t = 0; t < triangles.length; t += 3) {
      const meets =
        isOwn(found[triangles[t]!]!) ||
        isOwn(found[triangles[t + 1]!]!) ||
        isOwn(found[triangles[t + 2]!]!);
      if (!meets) continue;
      for (let corner = t; corner < t + 3; corner++) {
        const vertex = triangles[corner]!;
        if (found[vertex]! < 0) {
          found[vertex] = vertices.length / 3;
          for (let k = 0; k < 3; k++) {
            const at = other.vertices[3 * vertex + k]! + kSide * kSteps * by[k]!;
            vertices.push(at);
            count(at);
          }
        }
        corners.push(found[vertex]!);
        count(found[vertex]!);
      }
    }
  });
  return {vertices, corners, own: block.triangles.length, beside};
}

/// Kinds of triangles: exposed by cutting, or left of the mesh's surface.
const kCut = 0;
const kLeft = 1;

export interface BlockSurface extends Surface {
  readonly onMesh: Int32Array; // for each vertex, the mesh's triangle that it is on, or -1
}

/// Returns the block's triangles, in the object's frame [m].  Normals include the neighbours'
/// triangles, so that no border shows; cut and uncut parts meet in a sharp edge.
export function makeBlockSurface(
  {lattice}: Solid,
  number: number,
  {vertices, corners, own}: Patch,
  skin: Skin,
): BlockSurface {
  const begin = beginOf(lattice, number);
  const step = lattice.spacingM / kSteps;
  const places = new Float64Array(vertices);
  for (let i = 0; i < places.length; i++) {
    places[i] = begin[i % 3]! + step * (places[i]! - kBeforeSteps);
  }
  const triangles = new Uint32Array(corners);
  const faces = measure(places, triangles);
  const kinds = kindsOf(number, places, triangles, faces, skin);
  const surface = makeSurface(places, triangles, {own, kinds, faces});
  const {positions, normals, index} = surface;
  const onMesh = new Int32Array(surface.source.length).fill(-1);
  index.forEach((vertex, corner) => {
    if (kinds[Math.floor(corner / 3)] === kCut || onMesh[vertex]! >= 0) return;
    const at = 3 * vertex;
    const [x, y, z] = [positions[at]!, positions[at + 1]!, positions[at + 2]!];
    onMesh[vertex] = skin.at(number, x, y, z, normals[at]!, normals[at + 1]!, normals[at + 2]!);
  });
  return {...surface, onMesh};
}

/// A triangle is left of the mesh if all of its corners are on the mesh and it faces the same way.
function kindsOf(
  number: number,
  places: Float64Array,
  triangles: Uint32Array,
  {faceNormals}: Faces,
  skin: Skin,
): Uint8Array {
  const kinds = new Uint8Array(triangles.length / 3).fill(kCut);
  const isOn = new Uint8Array(places.length / 3);
  for (let v = 0; v < isOn.length; v++) {
    isOn[v] = skin.isAt(number, places[3 * v]!, places[3 * v + 1]!, places[3 * v + 2]!) ? 1 : 0;
  }
  for (let t = 0; t < triangles.length; t += 3) {
    let isLeft = true;
    for (let corner = t; isLeft && corner < t + 3; corner++) {
      const v = triangles[corner]!;
      isLeft =
        isOn[v] === 1 &&
        skin.at(
          number,
          places[3 * v]!,
          places[3 * v + 1]!,
          places[3 * v + 2]!,
          faceNormals[t]!,
          faceNormals[t + 1]!,
          faceNormals[t + 2]!,
        ) >= 0;
    }
    if (isLeft) kinds[t / 3] = kLeft;
  }
  return kinds;
}

const kPlaces = new WeakMap<Block, Places>();

function placesOf(block: Block): Places {
  let places = kPlaces.get(block);
  if (!places) kPlaces.set(block, (places = new Places(block.vertices)));
  return places;
}

/// Finds the vertices of a block by position: neighbouring blocks share them.
class Places {
  private readonly table: Int16Array; // vertex indices, or -1; open addressing
  private readonly mask: number;
  private readonly low: Vec3;
  private readonly high: Vec3;

  constructor(private readonly vertices: Uint8Array) {
    const count = vertices.length / 3;
    this.table = new Int16Array(2 << Math.ceil(Math.log2(count + 1))).fill(-1);
    this.mask = this.table.length - 1;
    const low: [number, number, number] = [Infinity, Infinity, Infinity];
    const high: [number, number, number] = [-Infinity, -Infinity, -Infinity];
    for (let i = 0; i < vertices.length; i++) {
      low[i % 3] = Math.min(low[i % 3]!, vertices[i]!);
      high[i % 3] = Math.max(high[i % 3]!, vertices[i]!);
    }
    [this.low, this.high] = [low, high];
    for (let vertex = 0; vertex < count; vertex++) {
      const at = 3 * vertex;
      this.table[this.slotOf(vertices[at]!, vertices[at + 1]!, vertices[at + 2]!)] = vertex;
    }
  }

  /// For each vertex of a neighbour, returns the vertex at the same place, or -1; undefined if no
  /// vertex is shared.
  find(other: Block, by: Vec3): Int32Array | undefined {
    let found: Int32Array | undefined;
    const {low, high} = this;
    const side = kSide * kSteps;
    const dx = side * by[0];
    const dy = side * by[1];
    const dz = side * by[2];
    for (let at = 0; at < other.vertices.length; at += 3) {
      const x = other.vertices[at]! + dx;
      if (x < low[0] || x > high[0]) continue;
      const y = other.vertices[at + 1]! + dy;
      if (y < low[1] || y > high[1]) continue;
      const z = other.vertices[at + 2]! + dz;
      if (z < low[2] || z > high[2]) continue;
      const vertex = this.table[this.slotOf(x, y, z)]!;
      if (vertex < 0) continue;
      found ??= new Int32Array(other.vertices.length / 3).fill(-1);
      found[at / 3] = vertex;
    }
    return found;
  }

  /// Returns the slot of a position in the table, or the free slot for it.
  private slotOf(x: number, y: number, z: number): number {
    const {vertices, table, mask} = this;
    let slot = (Math.imul(x, 73856093) ^ Math.imul(y, 19349663) ^ Math.imul(z, 83492791)) & mask;
    for (; table[slot]! >= 0; slot = (slot + 1) & mask) {
      const at = 3 * table[slot]!;
      if (vertices[at] === x && vertices[at + 1] === y && vertices[at + 2] === z) break;
    }
    return slot;
  }
}
