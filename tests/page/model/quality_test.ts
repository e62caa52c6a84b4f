import {expect, test} from "vitest";

import {PictureQuality, qualityOf, qualityWords} from "@page/model/quality";

test("a slow turn of the view makes turns rougher, and the view at rest stays as it is", () => {
  const quality = new PictureQuality(false, undefined);
  for (let i = 0; i < 20; i++) quality.took("objects", 300);
  expect(quality.names).toEqual({rest: "full", motion: "low"});
  expect(quality.share).toBe(1);
  for (let i = 0; i < 20; i++) quality.took("tools", 60);
  expect(quality.share).toBeLessThan(1);
  // Without a graphics card the first turn is in haste already.
  expect(new PictureQuality(true, undefined).names).toEqual({rest: "full", motion: "low"});
});

test("what a picture of another kind cost is nobody's measure", () => {
  const quality = new PictureQuality(false, undefined);
  for (let i = 0; i < 100; i++) quality.took(i % 2 === 0 ? "objects" : "tools", 300);
  for (let i = 0; i < 100; i++) quality.took("else", 300);
  expect(quality.names).toEqual({rest: "full", motion: "full"});
});

test("a quality that is settled stays", () => {
  const quality = new PictureQuality(true, "good");
  for (let i = 0; i < 100; i++) expect(quality.took("tools", 300)).toBe(false);
  expect(quality.names).toEqual({rest: "good", motion: "good"});
});

test("a turn has never more pixels than the view at rest, nor the objects more than the canvas", () => {
  for (const name of ["full", "good", "fair", "low"] as const) {
    const {share, inMotion} = new PictureQuality(false, name);
    expect(inMotion.canvas).toBeLessThanOrEqual(share);
    expect(inMotion.share).toBeLessThanOrEqual(inMotion.canvas);
  }
});

test("the words say what is left out", () => {
  expect(qualityWords(new PictureQuality(false, undefined))).toBe(
    "At rest full: all of the screen's pixels. While the view turns full: as at rest.",
  );
  expect(qualityWords(new PictureQuality(false, "low"))).toBe(
    "At rest low: 50 % of the screen's pixels a side. While the view turns low: " +
      "30 % for the objects, rougher edges, fewer triangles.",
  );
});

test("an address may name a quality that there is", () => {
  expect(qualityOf("fair")).toBe("fair");
  expect(qualityOf("splendid")).toBeUndefined();
});
