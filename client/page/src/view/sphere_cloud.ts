import {
  Color,
  type Group,
  IcosahedronGeometry,
  InstancedMesh,
  Matrix4,
  MeshStandardMaterial,
  Vector3,
} from "three";

import type {Body, SphereLevel} from "../model/bundle";
import type {BodyMesh} from "./body_mesh";
import {extend} from "./extend";
import type {Palette} from "./palette";
import {paintForScreen} from "./still_layer";

/// Few spheres are drawn rounder than many, so that the number of triangles stays bounded.
const kRoundness = [
  {spheres: 200, detail: 4},
  {spheres: 2000, detail: 3},
  {spheres: 8000, detail: 2},
  {spheres: Infinity, detail: 1},
] as const;

/// Clear in the middle, with a rim, so that nested spheres can be told apart.
function asBubble(material: MeshStandardMaterial): void {
  const bubble = `float facing = abs(dot(normalize(normal), normalize(vViewPosition)));
  diffuseColor.a = 0.05 + 0.6 * pow(1.0 - facing, 3.0);
  #include <opaque_fragment>`;
  extend(material, "bubble", {}, [], {}, {at: {"#include <opaque_fragment>": bubble}});
}

/// One level of a body's sphere tree.
class SphereCloud {
  private readonly mesh: InstancedMesh<IcosahedronGeometry, MeshStandardMaterial>;

  constructor(
    level: SphereLevel,
    private readonly parent: Group,
    private readonly isLeaves: boolean,
  ) {
    const count = level.radii.length;
    const {detail} = kRoundness.find(({spheres}) => count <= spheres)!;
    // The leaves represent the body; the levels above enclose it and are transparent.
    const material = new MeshStandardMaterial({
      roughness: 0.55,
      transparent: !isLeaves,
      depthWrite: isLeaves,
    });
    material.onBeforeCompile = paintForScreen;
    if (!isLeaves) asBubble(material);
    this.mesh = new InstancedMesh(new IcosahedronGeometry(1, detail), material, count);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = isLeaves ? 0 : 5;
    const matrix = new Matrix4();
    level.radii.forEach((radius, i) => {
      matrix
        .makeScale(radius, radius, radius)
        .setPosition(new Vector3().fromArray(level.centres, 3 * i));
      this.mesh.setMatrixAt(i, matrix);
    });
    parent.add(this.mesh);
  }

  /// @param colour  of the body.   @param ink  a contrasting colour
  paint(colour: Color, ink: Color): void {
    this.mesh.material.color.copy(colour);
    if (!this.isLeaves) this.mesh.material.color.lerp(ink, 0.45);
  }

  dispose(): void {
    this.parent.remove(this.mesh);
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.mesh.dispose();
  }
}

/// The number of levels of the deepest tree; the last one is the leaves.
export const levelsOf = (bodies: readonly Body[]): number =>
  Math.max(0, ...bodies.map(({geometry}) => geometry.levels.length));

/// One level of the sphere trees of all bodies, or none.
export class SphereClouds {
  private clouds: {cloud: SphereCloud; body: BodyMesh}[] = [];

  /// @param level  from 0, coarse; undefined: none
  show(
    objects: readonly BodyMesh[],
    tools: readonly BodyMesh[],
    level: number | undefined,
    palette: Palette,
  ): void {
    this.clear();
    const bodies = [...objects, ...tools];
    for (const {mesh} of bodies) mesh.visible = true;
    if (level === undefined) return;
    // Trees of one scene may differ in depth: the leaves are at the same end of the slider.
    const fromLeaves = levelsOf(bodies.map(({body}) => body)) - 1 - level;
    this.clouds = bodies.map((body) => {
      const {levels} = body.body.geometry;
      const own = Math.max(0, levels.length - 1 - fromLeaves);
      const isLeaves = own === levels.length - 1;
      const parent = isLeaves || tools.includes(body) ? body.group : body.over;
      body.mesh.visible = !isLeaves;
      return {cloud: new SphereCloud(levels[own]!, parent, isLeaves), body};
    });
    this.paint(palette);
  }

  paint({ink}: Palette): void {
    for (const {cloud, body} of this.clouds) cloud.paint(body.mesh.material.color, ink);
  }

  clear(): void {
    for (const {cloud} of this.clouds) cloud.dispose();
    this.clouds = [];
  }
}
