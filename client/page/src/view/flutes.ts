import type {IUniform, Material} from "three";

import type {Bur} from "../model/bundle";
import {extend} from "./extend";

/// Draws the flutes of a bur's head, which blur while it turns: its mesh has none, as its profile
/// is round.
/// @param turns  1: it turns; 0: it stands still
export function addFlutes(
  material: Material,
  {curve, rounding}: Bur,
  turns: IUniform<number>,
): void {
  const uniforms = {
    uTurns: turns,
    uHead: {value: Math.max(...curve.map(([, y]) => y)) + rounding},
    uPitch: {value: Math.max(...curve.map(([rho]) => rho)) + rounding},
  };
  const dark = `#include <color_fragment>
  float flute = sin(8.0 * atan(vBur.x, vBur.z) + 4.0 * vBur.y / uPitch);
  float dark = mix(0.6 * smoothstep(-0.2, 0.6, flute), 0.25, uTurns);
  diffuseColor.rgb *= 1.0 - dark * step(vBur.y, uHead);`;
  const fragment = {at: {"#include <color_fragment>": dark}};
  extend(material, "flutes", uniforms, ["vec3 vBur"], {main: "vBur = position;"}, fragment);
}
