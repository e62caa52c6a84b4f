import {expect, test} from "vitest";

import {edgePlace} from "@page/model/edge_place";

const kRoom = {width: 400, top: 50, height: 200};
const kHeight = 300;
/// The tangent of half the field of view is 0.5: at a metre the picture is 1 m high, 1.33 m wide.
const place = (x: number, y: number, z: number) => edgePlace([x, y, z], 0.5, kRoom, kHeight, 20);

test("what is in the picture has no arrow", () => {
  expect(place(0, 0, -1)).toBeUndefined();
  expect(place(0.66, 0.33, -1)).toBeUndefined();
  expect(place(-0.66, -0.33, -1)).toBeUndefined();
});

test("what is beyond an edge has one there, which points to it", () => {
  expect(place(2, 0, -1)).toMatchObject({x: 380, y: 150});
  expect(place(2, 0, -1)!.angle).toBeCloseTo(0);
  expect(place(-2, 0, -1)).toMatchObject({x: 20, y: 150});
  expect(Math.cos(place(-2, 0, -1)!.angle)).toBeCloseTo(-1);
  // Towards a corner: along the line from the middle to it.
  expect(place(2, 1.5, -1)!.x - 200).toBeCloseTo(((100 - 20) * 2) / 1.5);
});

test("what buttons or a trial cover is not seen, and the arrow stands beside them", () => {
  expect(place(0, -0.34, -1)).toMatchObject({x: 200, y: 230, angle: Math.PI / 2});
  expect(place(0, 0.34, -1)).toMatchObject({x: 200, y: 70, angle: -Math.PI / 2});
});

test("what is behind the eye lies on the side on which it is", () => {
  expect(place(0.1, 0, 1)).toMatchObject({x: 380, y: 150});
  expect(place(0, 0.1, 1)!.y).toBe(70);
});
