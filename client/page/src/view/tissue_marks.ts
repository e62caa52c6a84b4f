import {Color, type Material, Vector3} from "three";

import type {Body, Region} from "../model/bundle";
import {extend} from "./extend";

/// A cut tissue's colour if viewers choose it (idl/scene.fbs).
export const kNoColour = 0x1000000;

/// Draws the tissues that come to the surface, such as decay in a fissure or a marked outline, and
/// their borders where they are cut.  Only boxes and balls: a mesh lies within its body, and what is
/// cut of it has its colour.
export function markTissues(material: Material, {regions, cutColours}: Body): void {
  const isBox = (at: number): boolean => regions[at]!.low.some((x, i) => x < regions[at]!.high[i]!);
  const shown = regions.filter(
    ({radiusM, tissue}, at) => (radiusM > 0 || isBox(at)) && cutColours[tissue]! < kNoColour,
  );
  if (shown.length === 0) return;
  // What takes precedence over them.
  const over = regions.filter((one, at) => at > regions.indexOf(shown[0]!) && !shown.includes(one));
  const colourOf = ({tissue}: Region): Color => new Color(cutColours[tissue]);
  const uniforms = {
    uLow: {value: shown.map(({low}) => new Vector3(...low))},
    uHigh: {value: shown.map(({high}) => new Vector3(...high))},
    uRadius: {value: shown.map(({radiusM}) => radiusM)},
    uTissue: {value: shown.map(colourOf)},
    uOver: {value: [new Color(-1, -1, -1), ...over.map(colourOf)]},
  };
  const mark = `#include <color_fragment>
  float under = 1.0;
  for (int i = 0; i <= ${over.length}; i++)
    under = min(under, step(0.01, distance(diffuseColor.rgb, uOver[i])));
  for (int i = 0; i < ${shown.length}; i++) {
    vec3 past = max(uLow[i] - vBody, vBody - uHigh[i]);
    float outside = uRadius[i] > 0.0 ? distance(vBody, uLow[i]) - uRadius[i]
                                     : max(past.x, max(past.y, past.z));
    float soft = max(1e-5, fwidth(outside));
    diffuseColor.rgb = mix(uTissue[i], diffuseColor.rgb, max(1.0 - under, smoothstep(-soft, soft, outside)));
  }`;
  const [name, vertex] = [`tissues ${shown.length} ${over.length}`, {main: "vBody = position;"}];
  const fragment = {at: {"#include <color_fragment>": mark}};
  extend(material, name, uniforms, ["vec3 vBody"], vertex, fragment);
}
