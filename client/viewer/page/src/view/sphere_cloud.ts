import {
  Color,
  type Group,
  IcosahedronGeometry,
  InstancedMesh,
  Matrix4,
  MeshStandardMaterial,
} from "three";

import type {SphereLevel} from "../model/bundle";
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
  material.onBeforeCompile = (shader) => {
    paintForScreen(shader);
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <opaque_fragment>",
      `float facing = abs(dot(normalize(normal), normalize(vViewPosition)));
      diffuseColor.a = 0.05 + 0.6 * pow(1.0 - facing, 3.0);
      #include <opaque_fragment>`,
    );
  };
}

/// One level of a body's sphere tree.
export class SphereCloud {
  private readonly mesh: InstancedMesh<IcosahedronGeometry, MeshStandardMaterial>;

  constructor(
    private readonly level: SphereLevel,
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
    if (isLeaves) material.onBeforeCompile = paintForScreen;
    else asBubble(material);
    this.mesh = new InstancedMesh(new IcosahedronGeometry(1, detail), material, count);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = isLeaves ? 0 : 5;
    this.placeAll();
    parent.add(this.mesh);
  }

  /// @param colour  of the body.   @param ink  a contrasting colour
  paint(colour: Color, ink: Color): void {
    this.mesh.material.color.copy(colour);
    if (!this.isLeaves) this.mesh.material.color.lerp(ink, 0.45);
  }

  private placeAll(): void {
    const {centres, radii} = this.level;
    const matrix = new Matrix4();
    radii.forEach((radius, i) => {
      matrix.makeScale(radius, radius, radius);
      matrix.setPosition(centres[3 * i]!, centres[3 * i + 1]!, centres[3 * i + 2]!);
      this.mesh.setMatrixAt(i, matrix);
    });
    this.mesh.instanceMatrix.needsUpdate = true;
  }

  dispose(): void {
    this.parent.remove(this.mesh);
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.mesh.dispose();
  }
}
