import {expect, test} from "vitest";

import {fdiOf} from "@page/model/fdi";

test("teeth are numbered by quadrant and place", () => {
  expect(fdiOf("upper-right-central-incisor")).toBe("11");
  expect(fdiOf("upper-left-canine")).toBe("23");
  expect(fdiOf("lower-left-first-molar")).toBe("36");
  expect(fdiOf("lower-right-second-premolar")).toBe("45");
});

test("what is no tooth has no number", () => {
  for (const name of ["tooth", "tongue", "upper-jaw", "upper-left", "upper-left-tusk"]) {
    expect(fdiOf(name)).toBeUndefined();
  }
});
