import {Color} from "three";

import type {Tissue} from "../model/tissue";
import {colourOf} from "../ui/plots";

const kNames = [
  ...(["force", "torque", "contact", "halo", "ghost", "ink", "paper", "glow"] as const),
  ...(["soft", "sky", "ground"] as const),
];

/// The picture's colours, read from the style sheet, so that plots, figures and arrows agree and
/// light and dark are distinguished in one place.
export type Palette = Readonly<Record<(typeof kNames)[number], Color>> & {
  readonly tools: readonly Color[];
  readonly objects: readonly Color[];
};

export function readPalette(): Palette {
  const colour = (name: string): Color => new Color(colourOf(name));
  const colours = Object.fromEntries(kNames.map((name) => [name, colour(name)]));
  return {
    ...(colours as Record<(typeof kNames)[number], Color>),
    tools: [1, 2, 3, 4].map((i) => colour(`tool-${i}`)),
    objects: [1, 2, 3, 4].map((i) => colour(`object-${i}`)),
  };
}

/// A few objects get one colour each; many (teeth) get the same.
export function objectColour(
  palette: Palette,
  tissue: Tissue,
  index: number,
  rigid: number,
): Color {
  if (tissue === "soft") {
    // Neighbours of the same tissue differ slightly in lightness.
    return palette.soft.clone().offsetHSL(0, 0, 0.035 * ((index % 3) - 1));
  }
  const {objects} = palette;
  return rigid <= objects.length ? objects[index % objects.length]! : objects[0]!;
}
