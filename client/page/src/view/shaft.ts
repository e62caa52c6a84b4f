import {DoubleSide, type Material, type Vector3} from "three";

import {extend} from "./extend";

// A long tool between the eye and its own end would hide the work.

/// How far its end reaches [of the work area's radius].
const kEnd = 0.25;
/// Cosines of the angles at the end between the eye and what is clear in part, and wholly: the first
/// view looks at a tool at 35 degrees at least.
const kClear = "0.82, 0.92";

/// Gives a closed body that the eye is in a flat cross-section, not a hole.
export function capEnds(material: Material): void {
  material.side = DoubleSide;
  const cap = `if (!gl_FrontFacing) outgoingLight = 0.15 * diffuseColor.rgb;
  #include <opaque_fragment>`;
  extend(material, "capped", {}, [], {}, {at: {"#include <opaque_fragment>": cap}});
}

/// Makes the shaft transparent where it hides what surrounds the end.
/// @param solid   the tool's material, which leaves it out there
/// @param veil    draws it there, transparent
/// @param sightM  radius of the work area
export function clear(solid: Material, veil: Material, end: Vector3, sightM: number): void {
  const uniforms = {
    uEnd: {value: end},
    uReach: {value: kEnd * sightM},
  };
  const parts: readonly [Material, string, string][] = [
    [solid, "solid", "if (clear > 0.0) discard;"],
    [veil, "veil", "if (clear <= 0.0) discard;\n  diffuseColor.a *= 1.0 - 0.8 * clear;"],
  ];
  const seen = `#include <project_vertex>
  vEnd = (modelViewMatrix * vec4(uEnd, 1.0)).xyz;
  vAt = mvPosition.xyz;
  vFrom = distance(position, uEnd);`;
  const main = `float clear = smoothstep(uReach, 1.2 * uReach, vFrom)
    * smoothstep(${kClear}, dot(normalize(vAt - vEnd), normalize(-vEnd)));`;
  const varyings = ["vec3 vEnd", "vec3 vAt", "float vFrom"];
  const vertex = {at: {"#include <project_vertex>": seen}};
  for (const [material, name, leave] of parts) {
    const at = {"#include <opaque_fragment>": `${leave}\n  #include <opaque_fragment>`};
    extend(material, name, uniforms, varyings, vertex, {main, at});
  }
}
