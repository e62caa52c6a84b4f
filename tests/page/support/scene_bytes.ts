import {Builder} from "flatbuffers";
import {SphereGeometry} from "three";
import {mergeVertices} from "three/examples/jsm/utils/BufferGeometryUtils.js";

import {
  BodyT,
  BurT,
  Contact,
  FeaturesT,
  Friction,
  GeometryT,
  GridT,
  MaterialT,
  PoseT,
  RegionT,
  Scene,
  SceneT,
  Vec3T,
} from "@wire";

import type {Pose, Vec3} from "@page/base/pose";

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
  readonly materials?: readonly {stiffness: number}[];
  readonly cutColours?: readonly number[]; // of what burs cut
  readonly tissues?: readonly string[]; // their names
  readonly regions?: readonly {centre: Vec3; radius: number; tissue: number}[]; // balls
  readonly look?: string;
  readonly burRadius?: number; // a round bur, whose tip is at its origin
}
export interface TestScene {
  readonly name: string;
  readonly tools: readonly TestBody[];
  readonly objects: readonly TestBody[];
  readonly compliance?: boolean;
}

/// A box of twelve triangles, two for each face.
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

/// A closed ball of rings and sectors.
export function ball(radius: number, rings = 16, sectors = 24): Mesh {
  const sphere = new SphereGeometry(radius, sectors, rings);
  for (const seamed of ["normal", "uv"]) sphere.deleteAttribute(seamed);
  const closed = mergeVertices(sphere, 1e-6 * radius);
  return {
    vertices: [...closed.getAttribute("position").array],
    triangles: [...closed.index!.array],
  };
}

/// Makes one leaf for each triangle.
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
/// The same, but burs cut its box, which has another material inside.
export const kCuttable: TestScene = {
  ...kTestScene,
  objects: [{...kTestScene.objects[0]!, cutColours: [0x1000000, 0x5a3a20]}],
};
/// And of which a ball comes to the surface, on top.
export const kMarked: TestScene = {
  ...kCuttable,
  name: "marked",
  objects: [
    {
      ...kCuttable.objects[0]!,
      tissues: ["shell", "core"],
      regions: [{centre: [0, 0.02, 0], radius: 0.01, tissue: 1}],
    },
  ],
};

export function sceneBytes(scene: TestScene): Uint8Array {
  const bodies = [...scene.tools, ...scene.objects];
  const wireOf = (body: TestBody): BodyT => bodyOf(body, bodies.indexOf(body));
  const wire = new SceneT(
    scene.name,
    bodies.map(geometryOf),
    scene.tools.map(wireOf),
    scene.objects.map(wireOf),
    1000,
    1,
    new FeaturesT(Contact.Surface, Friction.Off, scene.compliance ?? false, false),
  );
  const builder = new Builder(1 << 16);
  Scene.finishSceneBuffer(builder, wire.pack(builder));
  return builder.asUint8Array();
}

/// One packet of eight lanes above the leaves: as many nodes as there are leaves, eight at most.
function geometryOf({mesh, leaves}: TestBody): GeometryT {
  const lanes = Array.from({length: 8}, (_, i) => leaves[i]);
  const lane = (get: (leaf: Leaf) => number): number[] =>
    lanes.map((leaf) => (leaf ? get(leaf) : Number.NaN));
  const begin = [0];
  for (const leaf of leaves) begin.push(begin.at(-1)! + leaf.triangles.length);
  return Object.assign(new GeometryT(), {
    vertices: [...mesh.vertices],
    triangles: [...mesh.triangles],
    leafX: leaves.map(({centre}) => centre[0]),
    leafY: leaves.map(({centre}) => centre[1]),
    leafZ: leaves.map(({centre}) => centre[2]),
    leafRadius: leaves.map(({radius}) => radius),
    leafTriangleBegin: begin,
    leafTriangle: leaves.flatMap(({triangles}) => [...triangles]),
    nodeX: lane(({centre}) => centre[0]),
    nodeY: lane(({centre}) => centre[1]),
    nodeZ: lane(({centre}) => centre[2]),
    nodeRadius: lane(({radius}) => radius),
    nodeChild: lanes.map((leaf, i) => (leaf ? i : -1)),
    levelBegin: [0, 1],
    centroid: new Vec3T(),
  });
}

const kRigid = [{stiffness: Infinity}];

function bodyOf(
  {
    name,
    leaves,
    pose,
    materials = kRigid,
    cutColours,
    tissues = [],
    regions = [],
    look = "",
    burRadius,
  }: TestBody,
  geometry: number,
): BodyT {
  const {p, q} = pose ?? {p: [0, 0, 0], q: [1, 0, 0, 0]};
  const isPainted = leaves.some(({material}) => material !== undefined);
  return Object.assign(new BodyT(), {
    name,
    look,
    geometry,
    pose: new PoseT(new Vec3T(...p), ...q),
    materials: materials.map(({stiffness}) => new MaterialT(stiffness, 0, 0, Infinity)),
    leafMaterial: isPainted ? leaves.map(({material}) => material ?? 0) : [],
    bur: burRadius ? new BurT([0, 0], burRadius) : null,
    grid: cutColours
      ? new GridT(
          50e-6,
          cutColours.map(() => 1e6),
          cutColours.map(() => 0),
          regions.map(
            ({centre, radius, tissue}) =>
              new RegionT(new Vec3T(...centre), new Vec3T(...centre), radius, tissue),
          ),
          [],
          [...cutColours],
          [...tissues],
        )
      : null,
  });
}
