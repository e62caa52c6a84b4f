import type {Body, Material, SceneModel} from "./bundle";

/// How a part of a body feels, as far as it is shown by colour.
export type Tissue = "rigid" | "soft";
export const kTissues: readonly Tissue[] = ["rigid", "soft"];

export function tissueOf(material: Material | undefined, scene: SceneModel): Tissue {
  if (scene.soft && material && Number.isFinite(material.stiffness)) return "soft";
  return "rigid";
}

/// Returns the tissue at each vertex of a body's mesh, as an index into kTissues; undefined if it
/// is uniform.  A vertex between two tissues gets the later one of that list.
export function tissueByVertex(body: Body, scene: SceneModel): Uint8Array | undefined {
  const ofMaterial = body.materials.map((material) => kTissues.indexOf(tissueOf(material, scene)));
  if (body.leafMaterial.length === 0 || new Set(ofMaterial).size < 2) return undefined;
  const {triangles, leafTriangleBegin, leafTriangle, vertices} = body.geometry;
  const tissues = new Uint8Array(vertices.length / 3);
  body.leafMaterial.forEach((material, leaf) => {
    const tissue = ofMaterial[material] ?? 0;
    for (let i = leafTriangleBegin[leaf]!; i < leafTriangleBegin[leaf + 1]!; i++) {
      for (let corner = 0; corner < 3; corner++) {
        const vertex = triangles[3 * leafTriangle[i]! + corner]!;
        tissues[vertex] = Math.max(tissues[vertex]!, tissue);
      }
    }
  });
  return tissues;
}
