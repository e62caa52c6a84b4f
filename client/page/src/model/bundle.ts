import {ByteBuffer} from "flatbuffers";
import {BufferAttribute, BufferGeometry} from "three";

import {
  type Body as WireBody,
  type Geometry as WireGeometry,
  Scene as WireScene,
  type Vec3 as WireVec3,
} from "@wire";

import {kIdentity, type Pose, type Vec3} from "../base/pose";

/// A scene as the page draws it, read from the bytes of idl/scene.fbs.

export interface SphereLevel {
  readonly centres: Float32Array; // x y z, x y z, ... [m]
  readonly radii: Float32Array;
}

export interface Triangles {
  readonly vertices: Float32Array; // x y z, x y z, ... [m]
  readonly triangles: Uint32Array;
}
export interface Geometry extends Triangles {
  readonly leafTriangleBegin: Uint32Array;
  readonly leafTriangle: Uint32Array;
  readonly levels: readonly SphereLevel[]; // coarse to fine; the last level is the leaves
  readonly centroid: Vec3;
  readonly centre: Vec3; // of the bounding box
  readonly radiusM: number; // about the centre
}

export interface Material {
  readonly stiffness: number; // [N/m]; Infinity: rigid
}

export interface Body {
  readonly name: string;
  readonly geometry: Geometry;
  readonly pose: Pose; // X_WB
  readonly materials: readonly Material[];
  readonly leafMaterial: Uint8Array; // material of each leaf; empty: all have the first
  readonly look: string; // name of its look; empty: drawn by its material
  readonly margin: readonly Vec3[]; // closed curve of a gum's margin, in its frame; empty: unknown
  readonly ambient: Uint8Array; // visible share of the surroundings at each vertex; empty: all
  /// Of each material, 0xrrggbb, or 0x1000000: viewers choose.  Empty: burs do not cut the body.
  readonly cutColours: readonly number[];
  readonly tissues: readonly string[]; // name of each, as written in the scene; empty: unnamed
  readonly regions: readonly Region[]; // later ones take precedence
  readonly bur: Bur | undefined; // of a tool that cuts by turning
  readonly moved: number; // of an object: its group of ToolState.moved, from 1; 0: it stands still
}

/// The cutting part of a tool: a curve turned about the tool's y axis, and all within a distance of
/// it. Its tip is the tool's origin.
export interface Bur {
  /// Convex, from the axis and back to it [m].
  readonly curve: readonly (readonly [rho: number, y: number])[];
  readonly rounding: number; // that distance [m]
}

/// A part of a body that burs cut, with a tissue of its own; in the body's frame.
export interface Region {
  readonly low: Vec3; // of a box, or a ball's centre [m]
  readonly high: Vec3;
  readonly radiusM: number; // 0: a box, or a mesh
  readonly mesh: Triangles | undefined; // closed: what is within it
  readonly tissue: number; // index into the body's tissues
}

/// The initial view: along -from at a ball that fills the picture.
export interface FirstSight {
  readonly centre: Vec3;
  readonly radiusM: number;
  readonly from: Vec3; // unit
  readonly end?: Vec3 | undefined; // the working end of a tool
}

export interface SceneModel {
  readonly name: string;
  readonly tools: readonly Body[];
  readonly objects: readonly Body[];
  readonly soft: boolean; // has a finite stiffness
  readonly isCut: boolean; // burs can cut some of its objects
  readonly firstSight: FirstSight | undefined;
}

/// Length of a bundle file's header before the FlatBuffer; messages may leave the header out.
const kHeaderBytes = 40;
const kMagic = "PALP";

/// Throws if the bytes are not a scene.
export function readBundle(bytes: Uint8Array): SceneModel {
  const magic = String.fromCharCode(...bytes.subarray(0, kMagic.length));
  const content = magic === kMagic ? bytes.subarray(kHeaderBytes) : bytes;
  // The readers below use doubles in place, which needs 8-byte alignment.
  const aligned = content.byteOffset % 8 === 0 ? content : content.slice();
  const buffer = new ByteBuffer(aligned);
  if (aligned.length < 8 || !WireScene.bufferHasIdentifier(buffer)) {
    throw new Error("these bytes are no scene: server and page are of different versions");
  }
  const scene = WireScene.getRootAsScene(buffer);
  const geometries: Geometry[] = [];
  for (let i = 0; i < scene.geometriesLength(); i++) {
    geometries.push(readGeometry(scene.geometries(i)!));
  }
  const bodies = (count: number, at: (i: number) => WireBody | null): Body[] =>
    Array.from({length: count}, (_, i) => readBody(at(i)!, geometries));
  const features = scene.features();
  const objects = bodies(scene.objectsLength(), (i) => scene.objects(i));
  return {
    name: scene.name() ?? "",
    tools: bodies(scene.toolsLength(), (i) => scene.tools(i)),
    objects,
    soft: features?.compliance() ?? false,
    isCut: objects.some(({cutColours}) => cutColours.length > 0),
    firstSight: readFirstSight(scene),
  };
}

function readFirstSight(scene: WireScene): FirstSight | undefined {
  const sight = scene.firstSight();
  const centre = sight?.centre();
  const from = sight?.from();
  if (!sight || !centre || !from) return undefined;
  return {centre: vec3(centre), radiusM: sight.radius(), from: vec3(from)};
}

const vec3 = (of: WireVec3): Vec3 => [of.x(), of.y(), of.z()];

function readBody(body: WireBody, geometries: readonly Geometry[]): Body {
  const geometry = geometries[body.geometry()];
  if (!geometry) throw new Error(`body '${body.name() ?? ""}' names a geometry that is not there`);
  const materials: Material[] = [];
  for (let i = 0; i < body.materialsLength(); i++) {
    const material = body.materials(i)!;
    materials.push({stiffness: material.stiffness()});
  }
  const pose = body.pose();
  const p = pose?.p();
  return {
    name: body.name() ?? "",
    geometry,
    pose: pose && p ? {p: vec3(p), q: [pose.qw(), pose.qx(), pose.qy(), pose.qz()]} : kIdentity,
    materials,
    leafMaterial: body.leafMaterialArray() ?? new Uint8Array(),
    look: body.look() ?? "",
    ambient: body.ambientArray() ?? new Uint8Array(),
    cutColours: Array.from(body.grid()?.pressuresArray() ?? [], (_, material) =>
      body.grid()!.coloursLength() > 0 ? body.grid()!.colours(material)! : 0x1000000,
    ),
    tissues: Array.from({length: body.grid()?.namesLength() ?? 0}, (_, i) => body.grid()!.names(i)),
    regions: Array.from({length: body.grid()?.regionsLength() ?? 0}, (_, i) => regionOf(body, i)),
    bur: burOf(body),
    moved: body.moved(),
    margin: Array.from({length: body.marginLength()}, (_, i) => vec3(body.margin(i)!)),
  };
}

function regionOf(body: WireBody, i: number): Region {
  const region = body.grid()!.regions(i)!;
  const [low, high] = [vec3(region.low()!), vec3(region.high()!)];
  const mesh = body.grid()!.regionMeshes(i);
  // An empty list of a box or ball has no alignment, and could not be read in place.
  const vertices = mesh && mesh.verticesLength() > 0 && Float32Array.from(mesh.verticesArray()!);
  return {
    ...{low, high, radiusM: region.radius(), tissue: region.material()},
    mesh: vertices ? {vertices, triangles: mesh.trianglesArray()!} : undefined,
  };
}

function burOf(body: WireBody): Bur | undefined {
  const bur = body.bur();
  if (!bur || bur.at()) return undefined; // an edge does not turn
  const rounding = bur.rounding();
  const curve = Array.from(
    {length: bur.curveLength() / 2},
    (_, i) => [bur.curve(2 * i)!, rounding + bur.curve(2 * i + 1)!] as const,
  );
  return {curve, rounding};
}

function readGeometry(geometry: WireGeometry): Geometry {
  const vertices = Float32Array.from(geometry.verticesArray() ?? []);
  const centroid = geometry.centroid();
  const mesh = new BufferGeometry().setAttribute("position", new BufferAttribute(vertices, 3));
  mesh.computeBoundingSphere();
  const bounds = mesh.boundingSphere!;
  return {
    vertices,
    triangles: geometry.trianglesArray() ?? new Uint32Array(),
    leafTriangleBegin: geometry.leafTriangleBeginArray() ?? new Uint32Array(),
    leafTriangle: geometry.leafTriangleArray() ?? new Uint32Array(),
    levels: readLevels(geometry),
    centroid: centroid ? vec3(centroid) : [0, 0, 0],
    centre: bounds.center.toArray(),
    radiusM: Math.max(0, bounds.radius), // three.js gives an empty sphere the radius -1
  };
}

/// Returns the tree's inner nodes level by level (lanes without a node hold NaN), then its leaves.
function readLevels(geometry: WireGeometry): SphereLevel[] {
  const kLanes = 8;
  const levels: SphereLevel[] = [];
  const begin = geometry.levelBeginArray() ?? new Int32Array();
  const x = geometry.nodeXArray() ?? new Float32Array();
  const y = geometry.nodeYArray() ?? new Float32Array();
  const z = geometry.nodeZArray() ?? new Float32Array();
  const radius = geometry.nodeRadiusArray() ?? new Float32Array();
  for (let level = 0; level + 1 < begin.length; level++) {
    const centres: number[] = [];
    const radii: number[] = [];
    for (let i = kLanes * begin[level]!; i < kLanes * begin[level + 1]!; i++) {
      if (Number.isNaN(radius[i]!)) continue;
      centres.push(x[i]!, y[i]!, z[i]!);
      radii.push(radius[i]!);
    }
    levels.push({centres: Float32Array.from(centres), radii: Float32Array.from(radii)});
  }
  const leafX = geometry.leafXArray() ?? new Float64Array();
  const leafY = geometry.leafYArray() ?? new Float64Array();
  const leafZ = geometry.leafZArray() ?? new Float64Array();
  const centres = new Float32Array(3 * leafX.length);
  for (let i = 0; i < leafX.length; i++) {
    centres.set([leafX[i]!, leafY[i]!, leafZ[i]!], 3 * i);
  }
  levels.push({centres, radii: Float32Array.from(geometry.leafRadiusArray() ?? [])});
  return levels;
}
