import {readFileSync} from "node:fs";

import {describe, expect, test} from "vitest";

import {contrast, difference, kEyes} from "../support/colours";

const style = readFileSync(new URL("../../../client/page/src/style.css", import.meta.url), "utf8");
/// Of the style sheet's rule for a theme, by name.
const coloursOf = (selector: string): Record<string, string> => {
  const rule = new RegExp(`\\n${selector} \\{([^}]*)\\}`).exec(style)![1]!;
  return Object.fromEntries(
    [...rule.matchAll(/--([\w-]+): (#[0-9a-f]{6});/g)].map(([, name, hex]) => [name!, hex!]),
  );
};

/// Four times the least difference that is seen, in Oklab.
const kApart = 0.08;
/// What stands beside each other and means something else: arrows, plots and figures; the force bar.
const kSets = [
  ["force", "torque", "contact", "past", "ghost"],
  ["accent", "alarm"],
];

describe.each(Object.entries({light: ":root", dark: ':root\\[data-theme="dark"\\]'}))(
  "the %s colours",
  (_theme, selector) => {
    const of = coloursOf(selector);
    const pairs = kSets.flatMap((names) =>
      names.flatMap((a, i) => names.slice(i + 1).map((b) => [a, b] as const)),
    );

    test.each(Object.entries(kEyes))("are told apart by an eye with %s", (_eye, matrix) => {
      for (const [a, b] of pairs)
        expect(difference(of[a]!, of[b]!, matrix), `${a}, ${b}`).toBeGreaterThan(kApart);
    });

    test("are read on the page", () => {
      for (const name of [...kSets.flat(), "ink", "quiet", "good"])
        expect(contrast(of[name]!, of.paper!), name).toBeGreaterThanOrEqual(4.5);
    });
  },
);

test("differences are those of the eye that looks", () => {
  const [red, green] = ["#d4481c", "#b07400"];
  expect(difference(red, green, kEyes.usual!)).toBeGreaterThan(0.1);
  expect(difference(red, green, kEyes.deuteranopia!)).toBeLessThan(0.02);
  expect(contrast("#ffffff", "#000000")).toBeCloseTo(21);
});
