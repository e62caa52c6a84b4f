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
  type WebGLProgramParametersWithUniforms,
} from "three";

import type {Body} from "../model/bundle";
import {type BlockSurface, makeBlockSurface, makePatch} from "../model/block_surface";
import type {Vec3} from "../model/pose";
import {Skin} from "../model/skin";
import {type Block, kSide, type Lattice, type Solid} from "../model/solid";
import type {Surface} from "../model/surface";

/// Blocks are written into pages of so many vertices and triangles, wherever one is free: what changes
/// is sent to the card, and nothing else, and all of it is one call.
const kPageVertices = 64;
const kPageCorners = 3 * 2 * kPageVertices;
const kFirstPages = 32;
/// Of a vertex: place, normal, colour and gloss.
const kFloats = 10;
const kPageFloats = kFloats * kPageVertices;

/// How far behind the mesh the blocks' surface is seen where the mesh is still the surface [h]: the two
/// differ by less.
const kBehind = 0.5;
/// Of what has been cut, against what was smooth.
const kGloss = 0.25;
/// Where the scene does not say: what is softer than a body's hardest material, and what hardly withstands
/// [Pa against Pa].
const kSofter = [
  {colour: new Color(0xdcb26a), pressure: 1 / 3},
  {colour: new Color(0x6b4424), pressure: 1 / 15},
] as const;

/// Where the mesh is not its body's surface any more: for the shaders of both.
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
    uCut.value = new Data3DTexture(this.cut, ...blocks); // nearest of its own accord
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

  /// The mesh is left out where its block is cut.
  leaveOut(material: Material): void {
    this.extend(material, "left out where cut", (shader) => {
      shader.vertexShader = shader.vertexShader.replace(
        "void main() {",
        `uniform vec3 uBegin;
uniform float uPerBlock;
varying vec3 vBlock;
void main() {
  vBlock = uPerBlock * (position - uBegin);`,
      );
      shader.fragmentShader = shader.fragmentShader.replace(
        "void main() {",
        `uniform highp sampler3D uCut;
varying vec3 vBlock;
void main() {
  if (texelFetch(uCut, ivec3(vBlock), 0).r > 0.5) discard;`,
      );
    });
  }

  /// What lies in other blocks closes the seam, and the mesh hides the rest of it.  By depth alone, so
  /// that no gap opens between the two.
  putBehind(material: Material): void {
    this.extend(material, "behind where not cut", (shader) => {
      shader.vertexShader = shader.vertexShader
        .replace(
          "void main() {",
          `uniform highp sampler3D uCut;
uniform vec3 uBegin;
uniform float uPerBlock;
uniform float uBehind;
void main() {`,
        )
        .replace(
          "#include <project_vertex>",
          `#include <project_vertex>
  if (texelFetch(uCut, ivec3(uPerBlock * (position - uBegin)), 0).r < 0.5) {
    vec4 behind = projectionMatrix * (mvPosition - vec4(0.0, 0.0, uBehind, 0.0));
    gl_Position.z = behind.z * gl_Position.w / behind.w;
  }`,
        );
    });
  }

  private extend(
    material: Material,
    name: string,
    more: (shader: WebGLProgramParametersWithUniforms) => void,
  ): void {
    const before = material.onBeforeCompile.bind(material);
    const key = material.onBeforeCompile.toString();
    material.onBeforeCompile = (shader, renderer) => {
      before(shader, renderer);
      Object.assign(shader.uniforms, this.uniforms);
      more(shader);
    };
    material.customProgramCacheKey = () => `${name} ${key}`;
  }
}

/// What the mesh looks like.
export interface Paint {
  /// Colour and gloss at one of the surface's vertices.
  at(vertex: number): readonly [number, number, number, number];
  readonly hardest: Color; // of the body's materials
}

interface Drawn {
  block: Block | undefined; // undefined: it is to be drawn anew
  beside: number; // of its patch
  readonly pages: number[];
}

/// What burs have left of a body.  Drawn with its mesh, which leaves out the blocks that are cut; what was
/// the mesh's surface looks as it did.
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
  private solid: Solid | undefined; // that is drawn
  private version = 0; // of it

  /// @param of        the body's material
  /// @param material  another one like it
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

  /// Its colours are others.
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
    const colours = this.coloursOf(paint.hardest);
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

  /// Of each material: as the scene says, or the softer against the hardest, the darker.
  private coloursOf(hardest: Color): Color[] {
    const {cuts} = this.body;
    const most = Math.max(...cuts.map(({pressurePa}) => pressurePa));
    return cuts.map(({pressurePa, colour: said}) => {
      if (said !== undefined) return new Color(said);
      const colour = hardest.clone();
      let above = 1;
      for (const softer of kSofter) {
        const share = Math.log((above * most) / pressurePa) / Math.log(above / softer.pressure);
        colour.lerp(softer.colour, Math.min(1, Math.max(0, share)));
        above = softer.pressure;
      }
      return colour;
    });
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

    // A vertex between two materials is of both.
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

  /// Where the mesh's surface is left, its normal and colour.
  /// @param at  where the vertex is in the list
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
    geometry.dispose(); // what the card has of it
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
