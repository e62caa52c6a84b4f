import {
  BufferAttribute,
  BufferGeometry,
  Color,
  Data3DTexture,
  DynamicDrawUsage,
  InterleavedBuffer,
  InterleavedBufferAttribute,
  type Material,
  Mesh,
  type MeshMatcapMaterial,
  type MeshStandardMaterial,
  RedFormat,
  Vector3,
} from "three";

import type {Body} from "../model/bundle";
import {type BlockSurface, makeBlockSurface, makePatch} from "../model/block_surface";
import type {Vec3} from "../base/pose";
import {Skin} from "../model/skin";
import {type Block, kSide, type Lattice, type Solid} from "../model/solid";
import type {Surface} from "../model/surface";
import {extend} from "./extend";
import {kNoColour} from "./tissue_marks";

/// Blocks are written into free pages of this many vertices and triangles: only changes are
/// uploaded, and everything is one draw call.
const kPageVertices = 64;
const kPageCorners = 3 * 2 * kPageVertices;
const kFirstPages = 32;
/// Per vertex: position, normal, colour and gloss.
const kFloats = 10;
const kPageFloats = kFloats * kPageVertices;

/// Depth offset of the blocks' surface behind the mesh where the mesh is still the surface [h]; the
/// two differ by less.
const kBehind = 0.5;
/// Gloss of a cut surface relative to the original.
const kGloss = 0.08;
/// Where the mesh is no longer its body's surface, for the shaders of both.
class CutPlaces {
  readonly uniforms = {
    uCut: {value: new Data3DTexture(new Uint8Array(1), 1, 1, 1)},
    uBegin: {value: new Vector3()},
    uPerBlock: {value: 0},
    uBehind: {value: 0},
  };
  private cut = new Uint8Array(1);

  constructor() {
    this.renew([1, 1, 1]);
  }

  place({origin, spacingM, blocks}: Lattice): void {
    const {uBegin, uPerBlock, uBehind} = this.uniforms;
    uBegin.value.set(...origin);
    uPerBlock.value = 1 / (kSide * spacingM);
    uBehind.value = kBehind * spacingM;
    this.renew(blocks);
  }

  private renew(blocks: Vec3): void {
    const {uCut} = this.uniforms;
    uCut.value.dispose();
    this.cut = new Uint8Array(blocks[0] * blocks[1] * blocks[2]);
    uCut.value = new Data3DTexture(this.cut, ...blocks); // filters "nearest" by default
    uCut.value.format = RedFormat;
    uCut.value.unpackAlignment = 1;
    uCut.value.needsUpdate = true;
  }

  set(block: number, isCut: boolean): void {
    const value = isCut ? 255 : 0;
    if (this.cut[block] === value) return;
    this.cut[block] = value;
    this.uniforms.uCut.value.needsUpdate = true;
  }

  /// Makes a material discard the mesh where its block is cut.
  leaveOut(material: Material): void {
    const {uniforms} = this;
    const main = "vBlock = uPerBlock * (position - uBegin);";
    const leave = {main: "if (texelFetch(uCut, ivec3(vBlock), 0).r > 0.5) discard;"};
    extend(material, "left out where cut", uniforms, ["vec3 vBlock"], {main}, leave);
  }

  /// Neighbouring blocks close the seam; the mesh hides the rest of them.  The offset changes only
  /// the depth, so no gap opens between the two.
  putBehind(material: Material): void {
    const behind = `#include <project_vertex>
  if (texelFetch(uCut, ivec3(uPerBlock * (position - uBegin)), 0).r < 0.5) {
    vec4 behind = projectionMatrix * (mvPosition - vec4(0.0, 0.0, uBehind, 0.0));
    gl_Position.z = behind.z * gl_Position.w / behind.w;
  }`;
    const vertex = {at: {"#include <project_vertex>": behind}};
    extend(material, "behind where not cut", this.uniforms, [], vertex, {});
  }
}

/// What the mesh looks like.
export interface Paint {
  /// Returns colour and gloss at a vertex of the surface.
  at(vertex: number): readonly [number, number, number, number];
  readonly under: Color; // colour below the surface
}

interface Drawn {
  block: Block | undefined; // undefined: it must be redrawn
  beside: number; // hash of its patch
  readonly pages: number[];
}

/// The remaining part of a body that was cut.  Drawn together with its mesh, which leaves out the
/// blocks that are cut; the original surface keeps its look.
export class CutMesh {
  readonly mesh: Mesh<BufferGeometry, Material>;
  private readonly places = new CutPlaces();
  private vertices = new InterleavedBuffer(new Float32Array(), kFloats);
  private index = new BufferAttribute(new Uint32Array(), 1);
  private free: number[] = []; // pages
  private pages = 0;
  private readonly drawn = new Map<number, Drawn>();
  private lattice: Lattice | undefined;
  private skin: Skin | undefined;
  private solid: Solid | undefined; // the one drawn
  private version = 0; // its version

  /// @param of        the body's material
  /// @param material  a copy of it
  constructor(
    private readonly body: Body,
    private readonly surface: Surface,
    of: MeshStandardMaterial | MeshMatcapMaterial,
    material: MeshStandardMaterial | MeshMatcapMaterial,
  ) {
    this.places.leaveOut(of);
    this.places.putBehind(material);
    material.vertexColors = true;
    this.mesh = new Mesh(new BufferGeometry(), material);
    this.mesh.frustumCulled = false;
    this.grow(kFirstPages);
  }

  isBehind(solid: Solid | undefined): boolean {
    return solid !== this.solid || (solid?.version ?? 0) !== this.version;
  }

  /// The colours have changed.
  forgetColours(): void {
    for (const drawn of this.drawn.values()) {
      drawn.block = undefined;
      this.version = -1;
    }
  }

  catchUp(solid: Solid | undefined, paint: Paint): void {
    if (!this.isBehind(solid)) return;
    this.solid = solid;
    this.version = solid?.version ?? 0;
    const stale = new Set<number>();
    const touch = (number: number): void => {
      stale.add(number);
      solid?.forAround(number, (_, other) => stale.add(other));
    };
    for (const [number, {pages}] of this.drawn) {
      if (solid?.blocks.has(number)) continue;
      for (const page of pages) this.clear(page);
      this.drawn.delete(number);
      this.places.set(number, false);
      touch(number);
    }
    if (!solid) return;
    if (this.lattice !== solid.lattice) {
      this.lattice = solid.lattice;
      this.places.place(this.lattice);
      this.skin = new Skin(this.surface, this.lattice);
    }
    for (const [number, block] of solid.blocks) {
      if (this.drawn.get(number)?.block !== block) touch(number);
    }
    const colours = this.coloursOf(paint.under);
    for (const number of stale) {
      const block = solid.blocks.get(number);
      if (!block) continue;
      this.places.set(number, block.cut);
      let drawn = this.drawn.get(number);
      if (!drawn) this.drawn.set(number, (drawn = {block: undefined, beside: 0, pages: []}));
      const patch = makePatch(solid, number, block);
      if (drawn.block === block && drawn.beside === patch.beside) continue;
      [drawn.block, drawn.beside] = [block, patch.beside];
      const surface = makeBlockSurface(solid, number, patch, this.skin!);
      this.write(block, drawn.pages, surface, colours, paint);
    }
    this.mesh.geometry.setDrawRange(0, this.pages * kPageCorners);
  }

  /// Returns each material's colour: the scene's, or else the one below the body's look.
  private coloursOf(under: Color): Color[] {
    return this.body.cutColours.map((colour) => (colour < kNoColour ? new Color(colour) : under));
  }

  private write(
    block: Block,
    pages: number[],
    of: BlockSurface,
    colours: readonly Color[],
    paint: Paint,
  ): void {
    const {positions, normals, index, onMesh} = of;
    const count = of.source.length;
    const needed = Math.max(
      Math.ceil(count / kPageVertices),
      Math.ceil(index.length / kPageCorners),
    );
    while (pages.length > needed) this.clear(pages.pop()!);
    while (pages.length < needed) pages.push(this.take());

    // A vertex between two materials gets both.
    const tints = new Float32Array(4 * count);
    index.forEach((vertex, corner) => {
      const {materials} = block;
      const material = materials[materials.length === 1 ? 0 : Math.floor(corner / 3)]!;
      const {r, g, b} = colours[Math.min(material, colours.length - 1)]!;
      tints[4 * vertex]! += r;
      tints[4 * vertex + 1]! += g;
      tints[4 * vertex + 2]! += b;
      tints[4 * vertex + 3]! += 1;
    });
    const to = this.vertices.array as Float32Array;
    for (let i = 0; i < count; i++) {
      const at =
        pages[Math.floor(i / kPageVertices)]! * kPageFloats + kFloats * (i % kPageVertices);
      for (let k = 0; k < 3; k++) {
        to[at + k] = positions[3 * i + k]!;
        to[at + 3 + k] = normals[3 * i + k]!;
        to[at + 6 + k] = tints[4 * i + k]! / tints[4 * i + 3]!;
      }
      to[at + 9] = kGloss;
      if (onMesh[i]! >= 0) this.asBefore(onMesh[i]!, to, at, paint);
    }
    const corners = this.index.array as Uint32Array;
    pages.forEach((page, nth) => {
      const begin = page * kPageCorners;
      for (let k = 0; k < kPageCorners; k++) {
        const vertex = index[nth * kPageCorners + k] ?? -1;
        corners[begin + k] =
          vertex < 0
            ? 0
            : pages[Math.floor(vertex / kPageVertices)]! * kPageVertices + (vertex % kPageVertices);
      }
      this.vertices.addUpdateRange(page * kPageFloats, kPageFloats);
      this.index.addUpdateRange(begin, kPageCorners);
    });
    this.vertices.needsUpdate = this.index.needsUpdate = true;
  }

  /// Where the mesh's surface is left, copies its normal and colour.
  /// @param at  position of the vertex in the list
  private asBefore(triangle: number, to: Float32Array, at: number, paint: Paint): void {
    const {index, normals} = this.surface;
    const shares = this.skin!.sharesOf(triangle, to[at]!, to[at + 1]!, to[at + 2]!);
    to.fill(0, at + 3, at + kFloats);
    shares.forEach((share, corner) => {
      const vertex = index[3 * triangle + corner]!;
      const tint = paint.at(vertex);
      for (let k = 0; k < 3; k++) to[at + 3 + k]! += share * normals[3 * vertex + k]!;
      for (let k = 0; k < 4; k++) to[at + 6 + k]! += share * tint[k]!;
    });
  }

  private take(): number {
    const page = this.free.pop() ?? this.pages;
    this.pages = Math.max(this.pages, page + 1);
    if (page * kPageCorners >= this.index.array.length) this.grow(2 * page);
    return page;
  }

  private clear(page: number): void {
    (this.index.array as Uint32Array).fill(0, page * kPageCorners, (page + 1) * kPageCorners);
    this.index.addUpdateRange(page * kPageCorners, kPageCorners);
    this.index.needsUpdate = true;
    this.free.push(page);
  }

  private grow(pages: number): void {
    const {geometry} = this.mesh;
    geometry.dispose(); // frees it on the graphics card
    const floats = new Float32Array(pages * kPageFloats);
    floats.set(this.vertices.array as Float32Array);
    const corners = new Uint32Array(pages * kPageCorners);
    corners.set(this.index.array as Uint32Array);
    this.vertices = new InterleavedBuffer(floats, kFloats).setUsage(DynamicDrawUsage);
    this.index = new BufferAttribute(corners, 1).setUsage(DynamicDrawUsage);
    const attribute = (size: number, offset: number): InterleavedBufferAttribute =>
      new InterleavedBufferAttribute(this.vertices, size, offset);
    geometry.setAttribute("position", attribute(3, 0));
    geometry.setAttribute("normal", attribute(3, 3));
    geometry.setAttribute("color", attribute(4, 6));
    geometry.setIndex(this.index);
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.places.uniforms.uCut.value.dispose();
  }
}
