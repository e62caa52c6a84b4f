import {Color} from "three";

import type {Tissue} from "../model/tissue";

/// The picture's colours: the style sheet has them, so that plots, figures and arrows agree and
/// light and dark are told apart in one place.
export interface Palette {
  readonly force: Color;
  readonly torque: Color;
  readonly contact: Color;
  readonly halo: Color;
  readonly ghost: Color;
  readonly ink: Color;
  readonly paper: Color;
  readonly glow: Color;
  readonly tools: readonly Color[];
  readonly objects: readonly Color[];
  readonly soft: Color;
  readonly wearing: Color;
  readonly sky: Color;
  readonly ground: Color;
}

export function readPalette(): Palette {
  const style = getComputedStyle(document.documentElement);
  const colour = (name: string): Color => new Color(style.getPropertyValue(`--${name}`).trim());
  return {
    force: colour("force"),
    torque: colour("torque"),
    contact: colour("contact"),
    halo: colour("halo"),
    ghost: colour("ghost"),
    ink: colour("ink"),
    paper: colour("paper"),
    glow: colour("paper-glow"),
    tools: [1, 2, 3, 4].map((i) => colour(`tool-${i}`)),
    objects: [1, 2, 3, 4].map((i) => colour(`object-${i}`)),
    soft: colour("soft"),
    wearing: colour("wearing"),
    sky: colour("sky"),
    ground: colour("ground"),
  };
}

/// A few objects get a colour each; many (teeth) are alike.
export function objectColour(
  palette: Palette,
  tissue: Tissue,
  index: number,
  rigid: number,
): Color {
  if (tissue === "wearing") return palette.wearing;
  if (tissue === "soft") {
    // Neighbours of the same tissue differ by a shade.
    return palette.soft.clone().offsetHSL(0, 0, 0.035 * ((index % 3) - 1));
  }
  const {objects} = palette;
  return rigid <= objects.length ? objects[index % objects.length]! : objects[0]!;
}
