import {expect, test} from "vitest";

import {keyOf} from "@page/ui/keys";

test("a layout with Latin letters decides by its letters", () => {
  expect(keyOf({key: "w", code: "KeyW"})).toBe("w");
  expect(keyOf({key: "Z", code: "KeyW"})).toBe("z"); // French
  expect(keyOf({key: ",", code: "KeyM"})).toBe(",");
  expect(keyOf({key: "ö", code: "Semicolon"})).toBe("ö");
});

test("a layout without Latin letters decides by the key's place", () => {
  for (const key of ["ц", "Ц", "ς", "ص", "ไ", "\u0e31", "ै"]) {
    expect(keyOf({key, code: "KeyW"})).toBe("w");
  }
  expect(keyOf({key: "لا", code: "KeyB"})).toBe("b"); // two letters on one key
  expect(keyOf({key: "ж", code: "Semicolon"})).toBe("ж");
});

test("other keys have their names", () => {
  for (const key of ["Enter", "ArrowLeft", " ", "?", "Dead"]) {
    expect(keyOf({key, code: "KeyQ"})).toBe(key);
  }
});
