import {Color} from "three";

import {norm, scale, subtract, type Vec3} from "../base/pose";

/// How bodies with a "look" in their scene file are drawn: colour by position, and gloss.
/// Positions are in the body's frame, as scenes/catalogue/README.md defines it for teeth, gums,
/// tongues and faces.
export interface Look {
  readonly roughness: number; // 0: sharp reflections
  readonly shine: number; // strength of reflections
  readonly metal?: boolean; // reflections have its colour, and it has no diffuse colour
  readonly marks?: boolean; // a periodontal probe's millimetre marks, from its tip along y
  /// @param p  in mm.   @param n  unit.   @param highest  largest y of the body in mm
  tint(p: Vec3, n: Vec3, highest: number, out: Color): void;
}

const hex = (value: number): Color => new Color(value);

/// Smooth step: 0 below `from`, 1 above `to`; `from` may exceed `to`.
function step(from: number, to: number, x: number): number {
  const t = Math.min(1, Math.max(0, (x - from) / (to - from)));
  return t * t * (3 - 2 * t);
}

/// Noise from -1 to 1 with features about `grain` mm wide, so that large areas do not look painted.
function mottle([x, y, z]: Vec3, grain: number): number {
  const [a, b, c] = [x / grain, y / grain, z / grain];
  return (
    (Math.sin(a + 1.7 * Math.sin(b)) +
      Math.sin(1.3 * b + 1.9 * Math.sin(c)) +
      Math.sin(1.1 * c + 1.5 * Math.sin(a))) /
    3
  );
}

const kRoot = hex(0xd9bd88);
const kNeck = hex(0xe9d2a6);
const kEnamel = hex(0xf3ead8);
const kEdge = hex(0xe4e4e0);
const tooth: Look = {
  roughness: 0.34, // sharper reflections would show the mesh's triangles
  shine: 0.5,
  tint([x, y, z], _, highest, out) {
    out.copy(kRoot).lerp(kNeck, step(-0.8, 0.3, y));
    out.lerp(kEnamel, step(0.2, 0.45 * highest, y));
    out.lerp(kEdge, 0.7 * step(0.72 * highest, highest, y));
    out.multiplyScalar(1 + 0.02 * mottle([x, y, z], 1.1));
  },
};

const kMargin = hex(0xe8a49b);
const kAttached = hex(0xe2948c);
const kLining = hex(0xbb5450);
const gum: Look = {
  roughness: 0.3,
  shine: 0.6,
  tint(p, n, _, out) {
    out.copy(kLining).lerp(kAttached, step(-11, -6.5, p[1] + 1.2 * mottle(p, 2.5)));
    out.lerp(kAttached, 0.7 * step(0.5, 0.9, n[1])); // palate
    out.lerp(kMargin, step(-2.5, 0.5, p[1]));
    out.multiplyScalar(1 + 0.035 * mottle(p, 0.9));
  },
};

const kTongueTop = hex(0xe49c98);
const kTongueSide = hex(0xb9524f);
const tongue: Look = {
  roughness: 0.42,
  shine: 0.55,
  tint(p, n, _, out) {
    out.copy(kTongueSide).lerp(kTongueTop, step(0, 0.8, n[1]));
    out.multiplyScalar(1 + 0.06 * mottle(p, 0.55) + 0.04 * mottle(p, 2.2));
  },
};

const kCheek = hex(0xc45e58);
const kLip = hex(0xb85a5c);
const kSkin = hex(0xdca886);
/// Centre of the cavity: surfaces that face it are lining, those that face away are skin.
const kCavity: Vec3 = [0, 0, -20];
const face: Look = {
  roughness: 0.4,
  shine: 0.45,
  tint(p, n, _, out) {
    const away = subtract(p, kCavity);
    const outwards = (n[0] * away[0] + n[1] * away[1] + n[2] * away[2]) / norm(away);
    out.copy(kCheek).lerp(kLip, step(-0.5, 0.1, outwards));
    const far = step(42, 54, Math.hypot(p[0], p[1])) * step(-0.1, 0.3, outwards);
    out.lerp(kSkin, Math.max(far, step(0.72, 0.93, outwards)));
    out.multiplyScalar(1 + 0.03 * mottle(p, 1.4));
  },
};

const kTan = hex(0xb8935a);
const kBrown = hex(0x7c5a33);
const calculus: Look = {
  roughness: 0.85,
  shine: 0.3,
  tint(p, _, __, out) {
    const spots = mottle(scale(p, 1), 0.3);
    out.copy(kTan).lerp(kBrown, 0.35 + 0.35 * spots);
  },
};

const kSteel = hex(0xcdd3da);
const steel: Look = {
  roughness: 0.28,
  metal: true,
  shine: 1,
  tint: (_, __, ___, out) => void out.copy(kSteel),
};

const probe: Look = {...steel, marks: true};

const kLooks: Readonly<Record<string, Look>> = {tooth, gum, tongue, face, calculus, steel, probe};

/// Returns undefined if there is no such look: the body is drawn by its material.
export const lookOf = (name: string): Look | undefined => kLooks[name];
