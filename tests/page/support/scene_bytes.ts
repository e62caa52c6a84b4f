import {Builder} from "flatbuffers";

import {
  Body,
  Contact,
  Features,
  Friction,
  Geometry,
  Material,
  Pose as WirePose,
  Scene,
  Vec3 as WireVec3,
} from "@wire";

import type {Pose, Vec3} from "@page/model/pose";

/// Small scenes as the bytes that a server would send.

export interface Mesh {
  readonly vertices: readonly number[];
  readonly triangles: readonly number[];
}
export interface Leaf {
  readonly centre: Vec3;
  readonly radius: number;
  readonly triangles: readonly number[];
  readonly material?: number;
}
export interface TestBody {
  readonly name: string;
  readonly mesh: Mesh;
  readonly leaves: readonly Leaf[];
  readonly pose?: Pose;
  readonly materials?: readonly {stiffness: number; hardness: number}[];
}
export interface TestScene {
  readonly name: string;
  readonly tools: readonly TestBody[];
  readonly objects: readonly TestBody[];
  readonly compliance?: boolean;
  readonly removal?: boolean;
}

/// Twelve triangles, two a face.
export function box(side: number): Mesh {
  const h = side / 2;
  const vertices: number[] = [];
  for (let i = 0; i < 8; i++) vertices.push(i & 1 ? h : -h, i & 2 ? h : -h, i & 4 ? h : -h);
  // prettier-ignore
  const triangles = [
    0, 2, 1, 1, 2, 3, // -z
    4, 5, 6, 5, 7, 6, // +z
    0, 1, 4, 1, 5, 4, // -y
    2, 6, 3, 3, 6, 7, // +y
    0, 4, 2, 2, 4, 6, // -x
    1, 3, 5, 3, 7, 5, // +x
  ];
  return {vertices, triangles};
}

/// A ball of rings and sectors.
export function ball(radius: number, rings = 16, sectors = 24): Mesh {
  const vertices: number[] = [0, radius, 0];
  for (let ring = 1; ring < rings; ring++) {
    const polar = (Math.PI * ring) / rings;
    for (let sector = 0; sector < sectors; sector++) {
      const azimuth = (2 * Math.PI * sector) / sectors;
      vertices.push(
        radius * Math.sin(polar) * Math.cos(azimuth),
        radius * Math.cos(polar),
        radius * Math.sin(polar) * Math.sin(azimuth),
      );
    }
  }
  vertices.push(0, -radius, 0);
  const last = vertices.length / 3 - 1;
  const at = (ring: number, sector: number): number =>
    ring === 0 ? 0 : ring === rings ? last : 1 + (ring - 1) * sectors + (sector % sectors);
  const triangles: number[] = [];
  for (let ring = 0; ring < rings; ring++) {
    for (let sector = 0; sector < sectors; sector++) {
      const [a, b] = [at(ring, sector), at(ring, sector + 1)];
      const [c, d] = [at(ring + 1, sector), at(ring + 1, sector + 1)];
      if (ring > 0) triangles.push(a, b, c);
      if (ring + 1 < rings) triangles.push(b, d, c);
    }
  }
  return {vertices, triangles};
}

/// One leaf for each triangle, which is all of it.
export function leafPerTriangle(mesh: Mesh, radius: number): Leaf[] {
  return Array.from({length: mesh.triangles.length / 3}, (_, t) => {
    const centre: [number, number, number] = [0, 0, 0];
    for (let corner = 0; corner < 3; corner++) {
      const vertex = mesh.triangles[3 * t + corner]!;
      for (let i = 0; i < 3; i++) centre[i]! += mesh.vertices[3 * vertex + i]! / 3;
    }
    return {centre, radius, triangles: [t]};
  });
}

/// A ball above a box that lies at the origin, its top at 25 mm.
export const kTestScene: TestScene = {
  name: "test-box",
  tools: [
    {
      name: "ball",
      mesh: ball(0.012),
      leaves: [{centre: [0, 0, 0], radius: 0.012, triangles: []}],
      pose: {p: [0, 0.06, 0], q: [1, 0, 0, 0]},
    },
  ],
  objects: [{name: "box", mesh: box(0.05), leaves: leafPerTriangle(box(0.05), 0.004)}],
};
/// Its box is worn away triangle by triangle.
export const kWearable: TestScene = {
  ...kTestScene,
  removal: true,
  objects: [{...kTestScene.objects[0]!, materials: [{stiffness: Infinity, hardness: 1e-5}]}],
};

export function sceneBytes(scene: TestScene): Uint8Array {
  const builder = new Builder(1 << 16);
  const bodies = [...scene.tools, ...scene.objects];
  const geometries = bodies.map((body) => packGeometry(builder, body));
  const geometriesAt = Scene.createGeometriesVector(builder, geometries);
  const tools = scene.tools.map((body, i) => packBody(builder, body, i));
  const toolsAt = Scene.createToolsVector(builder, tools);
  const objects = scene.objects.map((body, i) => packBody(builder, body, scene.tools.length + i));
  const objectsAt = Scene.createObjectsVector(builder, objects);
  const name = builder.createString(scene.name);
  Scene.startScene(builder);
  Scene.addName(builder, name);
  Scene.addGeometries(builder, geometriesAt);
  Scene.addTools(builder, toolsAt);
  Scene.addObjects(builder, objectsAt);
  Scene.addStiffness(builder, 1000);
  Scene.addTorsionalStiffness(builder, 1);
  Scene.addFeatures(
    builder,
    Features.createFeatures(
      builder,
      Contact.Surface,
      Friction.Off,
      scene.compliance ?? false,
      scene.removal ?? false,
    ),
  );
  Scene.finishSceneBuffer(builder, Scene.endScene(builder));
  return builder.asUint8Array();
}

/// One packet of eight lanes above the leaves: as many nodes as there are leaves, eight at most.
function packGeometry(builder: Builder, body: TestBody): number {
  const {mesh, leaves} = body;
  const lanes = Array.from({length: 8}, (_, i) => leaves[i]);
  const begin = [0];
  for (const leaf of leaves) begin.push(begin.at(-1)! + leaf.triangles.length);
  const nan = Number.NaN;
  const vertices = Geometry.createVerticesVector(builder, Float64Array.from(mesh.vertices));
  const triangles = Geometry.createTrianglesVector(builder, Uint32Array.from(mesh.triangles));
  const leafVector = (axis: number): Float64Array =>
    Float64Array.from(leaves, (leaf) => leaf.centre[axis]!);
  const leafX = Geometry.createLeafXVector(builder, leafVector(0));
  const leafY = Geometry.createLeafYVector(builder, leafVector(1));
  const leafZ = Geometry.createLeafZVector(builder, leafVector(2));
  const radius = Geometry.createLeafRadiusVector(
    builder,
    Float64Array.from(leaves, (leaf) => leaf.radius),
  );
  const leafBegin = Geometry.createLeafTriangleBeginVector(builder, Uint32Array.from(begin));
  const leafTriangle = Geometry.createLeafTriangleVector(
    builder,
    Uint32Array.from(leaves.flatMap((leaf) => [...leaf.triangles])),
  );
  const lane = (get: (leaf: Leaf) => number): Float32Array =>
    Float32Array.from(lanes, (leaf) => (leaf ? get(leaf) : nan));
  const nodeX = Geometry.createNodeXVector(
    builder,
    lane((leaf) => leaf.centre[0]),
  );
  const nodeY = Geometry.createNodeYVector(
    builder,
    lane((leaf) => leaf.centre[1]),
  );
  const nodeZ = Geometry.createNodeZVector(
    builder,
    lane((leaf) => leaf.centre[2]),
  );
  const nodeRadius = Geometry.createNodeRadiusVector(
    builder,
    lane((leaf) => leaf.radius),
  );
  const nodeChild = Geometry.createNodeChildVector(
    builder,
    Int32Array.from(lanes, (leaf, i) => (leaf ? i : -1)),
  );
  const levelBegin = Geometry.createLevelBeginVector(builder, Int32Array.from([0, 1]));
  Geometry.startGeometry(builder);
  Geometry.addVertices(builder, vertices);
  Geometry.addTriangles(builder, triangles);
  Geometry.addLeafX(builder, leafX);
  Geometry.addLeafY(builder, leafY);
  Geometry.addLeafZ(builder, leafZ);
  Geometry.addLeafRadius(builder, radius);
  Geometry.addLeafTriangleBegin(builder, leafBegin);
  Geometry.addLeafTriangle(builder, leafTriangle);
  Geometry.addNodeX(builder, nodeX);
  Geometry.addNodeY(builder, nodeY);
  Geometry.addNodeZ(builder, nodeZ);
  Geometry.addNodeRadius(builder, nodeRadius);
  Geometry.addNodeChild(builder, nodeChild);
  Geometry.addLevelBegin(builder, levelBegin);
  Geometry.addCentroid(builder, WireVec3.createVec3(builder, 0, 0, 0));
  return Geometry.endGeometry(builder);
}

function packBody(builder: Builder, body: TestBody, geometry: number): number {
  const name = builder.createString(body.name);
  const materials = body.materials ?? [{stiffness: Infinity, hardness: Infinity}];
  Body.startMaterialsVector(builder, materials.length);
  for (const {stiffness, hardness} of [...materials].reverse()) {
    Material.createMaterial(builder, stiffness, 0, 0, hardness);
  }
  const materialsAt = builder.endVector();
  const painted = body.leaves.some((leaf) => leaf.material !== undefined);
  const leafMaterial = Body.createLeafMaterialVector(
    builder,
    Uint8Array.from(painted ? body.leaves.map((leaf) => leaf.material ?? 0) : []),
  );
  const {p, q} = body.pose ?? {p: [0, 0, 0], q: [1, 0, 0, 0]};
  Body.startBody(builder);
  Body.addName(builder, name);
  Body.addGeometry(builder, geometry);
  Body.addPose(builder, WirePose.createPose(builder, p[0], p[1], p[2], q[0], q[1], q[2], q[3]));
  Body.addMaterials(builder, materialsAt);
  Body.addLeafMaterial(builder, leafMaterial);
  return Body.endBody(builder);
}
