import {expect, test} from "vitest";

import {readBundle} from "@page/model/bundle";
import {kTissues, tissueByVertex, tissueOf} from "@page/model/tissue";

import {box, leafPerTriangle, sceneBytes} from "../support/scene_bytes";

const mesh = box(1);
/// The first two triangles, a face, are soft; the rest is rigid.
const halfSoft = (compliance: boolean) =>
  readBundle(
    sceneBytes({
      name: "jaw",
      compliance,
      tools: [],
      objects: [
        {
          name: "jaw",
          mesh,
          leaves: leafPerTriangle(mesh, 0.1).map((leaf, i) => ({...leaf, material: i < 2 ? 1 : 0})),
          materials: [{stiffness: Infinity}, {stiffness: 500}],
        },
      ],
    }),
  );

test("soft parts are told from rigid ones, vertex by vertex", () => {
  const scene = halfSoft(true);
  const tissues = tissueByVertex(scene.objects[0]!, scene)!;
  const soft = new Set(mesh.triangles.slice(0, 6));
  tissues.forEach((tissue, vertex) => {
    expect(kTissues[tissue]).toBe(soft.has(vertex) ? "soft" : "rigid");
  });
});

test("what a scene does not use does not show", () => {
  const scene = halfSoft(false);
  expect(tissueByVertex(scene.objects[0]!, scene)).toBeUndefined();
  expect(tissueOf({stiffness: 500}, scene)).toBe("rigid");
});
