import {Color} from "three";

/// How colours look to an eye that lacks a kind of cone, and how far two of them are apart.

type Three = readonly [number, number, number];
type Matrix = readonly [Three, Three, Three];

/// Of linear RGB, at full severity (Machado, Oliveira and Fernandes, "A physiologically-based model for
/// simulation of color vision deficiency", 2009).
export const kEyes: Readonly<Record<string, Matrix>> = {
  usual: [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
  ],
  protanopia: [
    [0.152286, 1.052583, -0.204868],
    [0.114503, 0.786281, 0.099216],
    [-0.003882, -0.048116, 1.051998],
  ],
  deuteranopia: [
    [0.367322, 0.860646, -0.227968],
    [0.280085, 0.672501, 0.047413],
    [-0.01182, 0.04294, 0.968881],
  ],
  tritanopia: [
    [1.255528, -0.076749, -0.178779],
    [-0.078411, 0.930809, 0.147602],
    [0.004733, 0.691367, 0.3039],
  ],
};

const times = (matrix: Matrix, of: Three): Three =>
  matrix.map((row) => row.reduce((sum, factor, i) => sum + factor * of[i]!, 0)) as unknown as Three;

/// 0 to 1, in proportion to light.
const linear = (hex: string): Three => new Color(hex).toArray() as [number, number, number];

/// Ottosson's Oklab, in which 0.02 is about the least difference that is seen.
function oklab(rgb: Three): Three {
  const cones = times(
    [
      [0.4122214708, 0.5363325363, 0.0514459929],
      [0.2119034982, 0.6806995451, 0.1073969566],
      [0.0883024619, 0.2817188376, 0.6299787005],
    ],
    rgb.map((value) => Math.min(1, Math.max(0, value))) as unknown as Three,
  ).map(Math.cbrt) as unknown as Three;
  return times(
    [
      [0.2104542553, 0.793617785, -0.0040720468],
      [1.9779984951, -2.428592205, 0.4505937099],
      [0.0259040371, 0.7827717662, -0.808675766],
    ],
    cones,
  );
}

export function difference(a: string, b: string, eye: Matrix): number {
  const [of, than] = [a, b].map((hex) => oklab(times(eye, linear(hex))));
  return Math.hypot(...of!.map((value, i) => value - than![i]!));
}

/// WCAG's, 1 to 21.
export function contrast(a: string, b: string): number {
  const [of, than] = [a, b].map((hex) => {
    const [red, green, blue] = linear(hex);
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue + 0.05;
  });
  return Math.max(of!, than!) / Math.min(of!, than!);
}
