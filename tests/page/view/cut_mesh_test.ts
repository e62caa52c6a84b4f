import {Color, type Material, type Mesh, type WebGLProgramParametersWithUniforms} from "three";
import {expect, test} from "vitest";

import {readBundle} from "@page/model/bundle";
import {Remains} from "@page/model/remains";
import {toSolidBlock} from "@page/protocol/messages";
import {BodyMesh, SurfaceCache} from "@page/view/body_mesh";
import type {Palette} from "@page/view/palette";

import {kCuttable, sceneBytes} from "../support/scene_bytes";
import {kPitBlock, pit, solidBlock} from "../support/solid_blocks";

const kBody = new Color(0xd9cdb6);
const palette = {objects: [kBody]} as unknown as Palette;

/// The box, what burs left of it, and what is drawn of that.
function cuttable(cuts = kCuttable.objects[0]!.cuts!) {
  const objects = [{...kCuttable.objects[0]!, cuts}];
  const scene = readBundle(sceneBytes({...kCuttable, objects}));
  const body = new BodyMesh(scene.objects[0]!, scene, "object", 0, new SurfaceCache());
  body.paint(palette);
  const remains = new Remains();
  let change = 0;
  const {geometry, material} = body.mesh.children[0] as Mesh;
  return {
    scene,
    remains,
    body,
    tell: (block: number, surface = pit(), cut = true): void =>
      void remains.cut(toSolidBlock(solidBlock("cube", block, ++change, surface, {cut}))),
    draw: (): boolean => {
      const isNew = body.setCut(remains.solidOf(0));
      body.catchUp();
      return isNew;
    },
    /// Places, colours and the like of the triangles that there are.
    drawn: (): {y: number; colour: Color}[] => {
      const index = geometry.getIndex()!;
      const corners = [...Array(Math.min(index.count, geometry.drawRange.count)).keys()];
      const triangles = corners
        .filter((corner) => corner % 3 === 0)
        .filter((corner) => index.getX(corner) !== index.getX(corner + 1));
      return triangles.flatMap((t) =>
        [0, 1, 2].map((k) => {
          const vertex = index.getX(t + k);
          const colour = geometry.getAttribute("color");
          return {
            y: geometry.getAttribute("position").getY(vertex),
            colour: new Color(colour.getX(vertex), colour.getY(vertex), colour.getZ(vertex)),
          };
        }),
      );
    },
    material: material as Material,
  };
}

/// 255: the mesh leaves it out.
function cutBlocks(material: Material): Uint8Array {
  const shader = {uniforms: {}, vertexShader: "", fragmentShader: ""};
  material.onBeforeCompile(shader as WebGLProgramParametersWithUniforms, undefined as never);
  const {uCut} = shader.uniforms as {uCut: {value: {image: {data: Uint8Array}}}};
  return uCut.value.image.data;
}

test("a block is drawn in its body's colour where that was its surface, and in what was bared", () => {
  const {body, scene, tell, draw, drawn} = cuttable();
  expect(scene.isCut).toBe(true);
  expect(draw()).toBe(false);
  tell(kPitBlock);
  expect(draw()).toBe(true);
  expect(draw()).toBe(false);
  const corners = drawn();
  expect(corners.length).toBe(18 * 3);
  const near = ({r, g, b}: Color, of: Color): boolean =>
    Math.hypot(r - of.r, g - of.g, b - of.b) < 1e-3;
  corners.forEach(({y, colour}, corner) => {
    if (corner < 3 * 8) expect(near(colour, kBody)).toBe(true);
    else expect(colour.r).toBeLessThan(0.6 * kBody.r); // soft, and so dark
    if (corner >= 3 * 16) expect(y).toBeCloseTo(0.018, 6);
  });
  // Another palette, as at night.
  const night = new Color(0x445566);
  body.paint({objects: [night]} as unknown as Palette);
  draw();
  expect(near(drawn()[0]!.colour, night)).toBe(true);
});

test("a material has the colour that its scene gives it", () => {
  const {tell, draw, drawn} = cuttable([{pressurePa: 3e6}, {pressurePa: 1e5, colour: 0xc2403c}]);
  tell(kPitBlock);
  draw();
  expect(drawn().at(-1)!.colour.getHexString()).toBe("c2403c");
});

test("the mesh leaves out the blocks that are cut, until they are undone", () => {
  const {remains, tell, draw, drawn, body} = cuttable();
  tell(kPitBlock);
  tell(kPitBlock + 1, pit(), false);
  draw();
  const cut = (): number[] =>
    [...cutBlocks(body.mesh.material).entries()].filter(([, is]) => is > 0).map(([i]) => i);
  expect(cut()).toEqual([kPitBlock]);
  remains.undo(1);
  draw();
  expect(cut()).toEqual([]);
  expect(drawn().length).toBe(18 * 3);
  body.paint(palette);
  remains.clear();
  expect(draw()).toBe(true);
  expect(drawn().length).toBe(0);
});

test("blocks that come and go, and grow, leave nothing behind", () => {
  const {remains, tell, draw, drawn} = cuttable();
  for (let block = 0; block < 60; block++) tell(block);
  draw();
  expect(drawn().length).toBe(60 * 18 * 3);
  for (let block = 0; block < 60; block += 2) tell(block, Uint8Array.of(0, 0, 0, 0));
  draw();
  expect(drawn().length).toBe(30 * 18 * 3);
  remains.undo(60);
  draw();
  expect(drawn().length).toBe(0);
  for (let block = 0; block < 40; block++) tell(block);
  draw();
  expect(drawn().length).toBe(40 * 18 * 3);
});
