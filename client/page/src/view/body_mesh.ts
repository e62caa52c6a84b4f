import {
  BufferAttribute,
  BufferGeometry,
  Color,
  Group,
  Mesh,
  type MeshMatcapMaterial,
  MeshStandardMaterial,
} from "three";

import type {Body, Geometry, SceneModel} from "../model/bundle";
import type {Pose} from "../base/pose";
import type {Solid} from "../model/solid";
import {makeSurface, type Surface} from "../model/surface";
import {kTissues, tissueByVertex, tissueOf} from "../model/tissue";
import {CutMesh, type Paint} from "./cut_mesh";
import {colourAt, glossy} from "./gloss";
import {type Look, lookOf} from "./looks";
import {objectColour, type Palette} from "./palette";
import {coarsen} from "./coarsen";
import {paintForScreen} from "./still_layer";
import {markTissues} from "./tissue_marks";

/// Buffers shared by bodies of the same geometry: uploaded once.
export class SurfaceCache {
  private readonly made = new Map<
    Geometry,
    {surface: Surface; position: BufferAttribute; normal: BufferAttribute; index: BufferAttribute}
  >();
  private readonly coarse = new Map<Surface, Promise<BufferAttribute[]>>();

  /// @return index buffers with fewer triangles over the same vertices
  coarser(surface: Surface, distancesM: readonly number[]): Promise<BufferAttribute[]> {
    let made = this.coarse.get(surface);
    if (!made) this.coarse.set(surface, (made = coarsen(surface, distancesM)));
    return made;
  }

  of(geometry: Geometry): {surface: Surface; buffers: BufferGeometry} {
    let entry = this.made.get(geometry);
    if (!entry) {
      const surface = makeSurface(geometry.vertices, geometry.triangles);
      entry = {
        surface,
        position: new BufferAttribute(surface.positions, 3),
        normal: new BufferAttribute(surface.normals, 3),
        index: new BufferAttribute(surface.index, 1),
      };
      this.made.set(geometry, entry);
    }
    const buffers = new BufferGeometry();
    buffers.setAttribute("position", entry.position);
    buffers.setAttribute("normal", entry.normal);
    buffers.setIndex(entry.index);
    return {surface: entry.surface, buffers};
  }
}

/// Colour below a look, if the scene has none.
const kUnderLook = new Color(0xf3ead8);

export function place(group: Group, pose: Pose): void {
  group.position.set(...pose.p);
  group.quaternion.set(pose.q[1], pose.q[2], pose.q[3], pose.q[0]);
}

/// A body drawn as a solid surface.
export class BodyMesh {
  readonly group = new Group();
  readonly over = new Group(); // at the same place, for what is drawn over tools
  readonly mesh: Mesh<BufferGeometry, MeshStandardMaterial | MeshMatcapMaterial>;
  private readonly surface: Surface;
  private readonly tissues: Uint8Array | undefined;
  private readonly look: Look | undefined;
  private readonly allTriangles: BufferAttribute;
  private coarse: readonly BufferAttribute[] = [];
  private readonly cut: CutMesh | undefined; // its cut part
  private solid: Solid | undefined;

  constructor(
    readonly body: Body,
    private readonly scene: SceneModel,
    private readonly role: "tool" | "object",
    private readonly place_: number,
    private readonly cache: SurfaceCache,
  ) {
    const {surface, buffers} = cache.of(body.geometry);
    this.surface = surface;
    this.allTriangles = buffers.getIndex()!;
    this.tissues = role === "object" ? tissueByVertex(body, scene) : undefined;
    this.look = lookOf(body.look);
    const material = this.makeMaterial();
    if (!this.look) material.vertexColors = this.tissues !== undefined;
    if (this.look) buffers.setAttribute("color", colourAt(this.look, surface, body.ambient));
    this.mesh = new Mesh(buffers, material);
    this.group.add(this.mesh);
    if (body.cutColours.length > 0) {
      const ofCut = this.makeMaterial();
      this.cut = new CutMesh(body, surface, material, ofCut);
      for (const one of [material, ofCut]) markTissues(one, body);
      this.mesh.add(this.cut.mesh);
    }
    place(this.group, body.pose);
    place(this.over, body.pose);
  }

  /// Returns another material like its own.
  makeMaterial(): MeshStandardMaterial | MeshMatcapMaterial {
    if (this.look) return glossy(this.look);
    const metalness = this.role === "tool" ? 0.08 : 0;
    const material = new MeshStandardMaterial({roughness: 0.62, metalness});
    material.onBeforeCompile = paintForScreen;
    return material;
  }

  paint(palette: Palette): void {
    const material = this.mesh.material;
    if (this.look) return; // independent of the theme
    this.cut?.forgetColours();
    if (this.role === "tool") {
      material.color.copy(palette.tools[this.place_ % palette.tools.length]!);
      return;
    }
    const rigid = this.scene.objects.filter(
      (object) => tissueOf(object.materials[0], this.scene) === "rigid",
    ).length;
    const colour = (tissue: (typeof kTissues)[number]): Color =>
      objectColour(palette, tissue, this.place_, rigid);
    if (!this.tissues) {
      material.color.copy(colour(tissueOf(this.body.materials[0], this.scene)));
      return;
    }
    const colours = kTissues.map(colour);
    const values = new Float32Array(3 * this.surface.source.length);
    this.surface.source.forEach((vertex, i) => {
      colours[this.tissues![vertex]!]!.toArray(values, 3 * i);
    });
    material.color.set(0xffffff);
    this.mesh.geometry.setAttribute("color", new BufferAttribute(values, 3));
  }

  /// Sets what burs have left of it.
  setCut(solid: Solid | undefined): boolean {
    this.solid = solid;
    return this.cut?.isBehind(solid) ?? false;
  }

  /// To be called before drawing: many blocks may have arrived, and some several times.
  catchUp(): void {
    if (this.mesh.visible) this.cut?.catchUp(this.solid, this.paintNow());
  }

  private paintNow(): Paint {
    const {color} = this.mesh.material;
    const colours = this.mesh.geometry.getAttribute("color") as BufferAttribute | undefined;
    const at: Paint["at"] = (i) =>
      colours
        ? [colours.getX(i), colours.getY(i), colours.getZ(i), this.look ? colours.getW(i) : 1]
        : [color.r, color.g, color.b, 1];
    return {at, under: this.look ? kUnderLook : color};
  }

  /// Makes coarser triangles.
  async makeCoarser(distancesM: readonly number[]): Promise<void> {
    this.coarse = await this.cache.coarser(this.surface, distancesM);
  }

  /// @param detail  0: all triangles, also used if there are no coarser ones
  setDetail(detail: number): void {
    // Beside a cut, coarser triangles would leave gaps.
    if (this.coarse.length === 0 || this.solid) return;
    this.mesh.geometry.setIndex(this.coarse[detail - 1] ?? this.allTriangles);
  }

  dispose(): void {
    this.cut?.dispose();
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}
