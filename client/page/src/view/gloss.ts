import {
  BufferAttribute,
  Color,
  DataTexture,
  DataUtils,
  HalfFloatType,
  LinearFilter,
  type Material,
  MeshMatcapMaterial,
  RGBAFormat,
} from "three";

import type {Vec3} from "../base/pose";
import type {Surface} from "../model/surface";
import {extend} from "./extend";
import type {Look} from "./looks";
import {paintForScreen} from "./still_layer";

// Gloss for bodies with a look, at the cost of one texture: the lights are fixed to the camera, so
// brightness depends only on the normal in the camera's frame and is looked up (a "matcap").
// Without a graphics card, physically based materials with an environment map reached less than one
// picture a second.

const kTexels = 192;

/// A soft window that the surface reflects, in the stereographic plane of reflected directions.
interface Window {
  readonly x: number;
  readonly y: number;
  readonly half: readonly [number, number];
  readonly bright: number;
}
const kWindows: readonly Window[] = [
  {x: -0.26, y: 0.36, half: [0.15, 0.11], bright: 1},
  {x: 0.4, y: 0.22, half: [0.05, 0.16], bright: 0.4},
];

const clamp01 = (x: number): number => Math.min(1, Math.max(0, x));

/// Returns the light reflected to the camera by a normal in its frame.
function mirrored(n: Vec3, look: Look): number {
  const r: Vec3 = [2 * n[2] * n[0], 2 * n[2] * n[1], 2 * n[2] * n[2] - 1];
  const x = r[0] / (1.02 + r[2]);
  const y = r[1] / (1.02 + r[2]);
  // Rough surfaces spread the same light over a larger spot.
  const soft = 0.03 + 0.5 * look.roughness;
  let light = 0;
  for (const {x: cx, y: cy, half, bright} of kWindows) {
    const off = Math.hypot(
      Math.max(0, Math.abs(x - cx) - half[0]),
      Math.max(0, Math.abs(y - cy) - half[1]),
    );
    const area = (half[0] * half[1]) / ((half[0] + soft) * (half[1] + soft));
    light += bright * Math.sqrt(area) * Math.exp(-((off / soft) ** 2));
  }
  if (look.metal) return 0.52 + 0.28 * r[1] + 0.25 * clamp01(r[2]) + light;
  const rim = (1 - clamp01(n[2])) ** 4;
  return light + 0.22 * rim * (1 - look.roughness);
}

/// Returns the diffuse light on a normal in the camera's frame.
function received([x, y, z]: Vec3): number {
  const key = clamp01((0.3 * x + 0.52 * y + 0.8 * z + 0.15) / 1.15);
  const fill = clamp01(-0.85 * x + 0.1 * y + 0.5 * z);
  return 0.33 + 0.1 * y + 0.62 * key + 0.1 * fill;
}

function matcapOf(look: Look): DataTexture {
  const values = new Uint16Array(4 * kTexels * kTexels);
  for (let row = 0; row < kTexels; row++) {
    for (let column = 0; column < kTexels; column++) {
      const x = (2 * (column + 0.5)) / kTexels - 1;
      const y = (2 * (row + 0.5)) / kTexels - 1;
      const r = Math.hypot(x, y);
      const inside = r > 0.999 ? 0.999 / r : 1;
      const [nx, ny] = [x * inside, y * inside];
      const n: Vec3 = [nx, ny, Math.sqrt(1 - nx * nx - ny * ny)];
      const colour = look.metal ? mirrored(n, look) : received(n);
      const shine = look.metal ? 0 : look.shine * mirrored(n, look);
      // Light that has gone through what is lit makes its shadows warm, not grey.
      const warm = look.metal ? [1, 1, 1] : [0.82, 1, 1.12];
      [...warm.map((power) => colour ** power), shine].forEach((value, i) => {
        values[4 * (row * kTexels + column) + i] = DataUtils.toHalfFloat(value);
      });
    }
  }
  const texture = new DataTexture(values, kTexels, kTexels, RGBAFormat, HalfFloatType);
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

const kMatcaps = new Map<Look, DataTexture>();

export function glossy(look: Look): MeshMatcapMaterial {
  let matcap = kMatcaps.get(look);
  if (!matcap) kMatcaps.set(look, (matcap = matcapOf(look)));
  const material = new MeshMatcapMaterial({matcap, vertexColors: true});
  // Reflections are added, scaled by the visibility of the surroundings: vColor.a.
  material.onBeforeCompile = (shader) => {
    paintForScreen(shader);
    shader.fragmentShader = shader.fragmentShader.replace(
      "vec3 outgoingLight = diffuseColor.rgb * matcapColor.rgb;",
      "vec3 outgoingLight = diffuseColor.rgb * matcapColor.rgb + matcapColor.a * vColor.a;",
    );
  };
  material.customProgramCacheKey = () => "glossy";
  if (look.marks) addMarks(material);
  return material;
}

/// Adds a probe's marks after UNC-15 to its straight part: a line at each millimetre from its tip,
/// and bands from 4 to 5 and from 9 to 10.  By position and not by vertex, so the mesh stays the
/// one that is felt.
function addMarks(material: Material): void {
  const functions = `float band(float from, float to) {
  float soft = max(1e-3, fwidth(vFromTipMm));
  return smoothstep(from - soft, from + soft, vFromTipMm)
       * (1.0 - smoothstep(to - soft, to + soft, vFromTipMm));
}`;
  const marks = `float mark = max(band(4.0, 5.0), band(9.0, 10.0));
  for (int mm = 1; mm <= 10; mm++) mark = max(mark, band(float(mm) - 0.07, float(mm) + 0.07));
  diffuseColor.rgb *= 1.0 - 0.88 * mark;
  vec3 outgoingLight`;
  const fragment = {functions, at: {"vec3 outgoingLight": marks}};
  const vertex = {main: "vFromTipMm = 1e3 * position.y;"};
  extend(material, "marked", {}, ["float vFromTipMm"], vertex, fragment);
}

/// Returns the look's colour at each vertex, and as fourth component the visibility
/// of the surroundings.
export function colourAt(look: Look, surface: Surface, ambient: Uint8Array): BufferAttribute {
  const {positions, normals, source} = surface;
  const mm = positions.map((value) => 1e3 * value);
  const at = (values: Float32Array, i: number): Vec3 => [
    values[3 * i]!,
    values[3 * i + 1]!,
    values[3 * i + 2]!,
  ];
  let highestMm = -Infinity;
  for (let i = 1; i < mm.length; i += 3) highestMm = Math.max(highestMm, mm[i]!);
  const values = new Float32Array(4 * source.length);
  const colour = new Color();
  source.forEach((vertex, i) => {
    look.tint(at(mm, i), at(normals, i), highestMm, colour);
    const open = ambient.length > 0 ? ambient[vertex]! / 255 : 1;
    values[4 * i] = colour.r * shaded(open, colour.r);
    values[4 * i + 1] = colour.g * shaded(open, colour.g);
    values[4 * i + 2] = colour.b * shaded(open, colour.b);
    values[4 * i + 3] = clamp01(1.6 * open);
  });
  return new BufferAttribute(values, 4);
}

/// Returns the light at a place that sees the share `open` of the surroundings: the lamp at the
/// camera lights what is seen, the surroundings the rest, and reflections from neighbours have
/// their colour (the polynomial of Jimenez et al., "Practical real-time strategies for accurate
/// indirect occlusion", 2016).
function shaded(open: number, albedo: number): number {
  const kLamp = 0.3;
  const a = 2.0404 * albedo - 0.3324;
  const b = -4.7951 * albedo + 0.6417;
  const c = 2.7552 * albedo + 0.6903;
  const room = Math.max(open, ((open * a + b) * open + c) * open);
  return kLamp + (1 - kLamp) * Math.min(1, 1.5 * room);
}
