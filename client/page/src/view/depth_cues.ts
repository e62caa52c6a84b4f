import {
  HalfFloatType,
  LinearFilter,
  Matrix4,
  type PerspectiveCamera,
  type Texture,
  Vector2,
  Vector3,
  Vector4,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";

import type {Ball} from "../model/first_sight";
import {kNearEndBalls} from "../model/near_end";
import {fullPicture} from "./full_picture";

// What tells depth on a flat screen: cavities are darker, and the tool casts a shadow that meets it
// where it touches.  Both are computed from the depth of the static objects, where they are copied
// into the picture.  A cavity is what lies deeper than the mean of its surroundings (Luft et al.,
// "Image enhancement by unsharp masking the depth buffer", 2006); that mean is smooth, so few
// texels hold it.

/// Direction to the lamp, in the eye's frame.
export const kToLamp = new Vector3(0.5, 0.9, 0.8).normalize();

/// Radius of the surroundings [of the work area's radius], and the texels that it has.
const kAround = 0.12;
const kTexels = 3;
const kMostTexels = 512; // per side
/// Taps per texel and side, so that fine parts do not flicker.
const kTaps = 4;

const kBehindEyeM = 1000;

/// Depth in the eye's frame relative to the middle of the work [of its radius].
const kDeep = `
uniform mat4 uToEye;
uniform float uMiddle;
uniform float uSight;
vec3 eyeOf(vec2 uv, float depth) {
  vec4 at = uToEye * (2.0 * vec4(uv, depth, 1.0) - 1.0);
  return at.xyz / at.w;
}
float deep(vec3 eye) { return (-eye.z - uMiddle) / uSight; }`;

/// What is behind everything does not count.  x: depth, y: the share of what counts, zw: where that
/// lies from the texel's middle [texels], all times the share.
const kGatherShader = `
${kDeep}
uniform highp sampler2D uDepth;
uniform vec2 uTexel;
void main() {
  gl_FragColor = vec4(0.0);
  for (int i = 0; i < ${kTaps * kTaps}; i++) {
    vec2 tap = (vec2(i % ${kTaps}, i / ${kTaps}) + 0.5) / ${kTaps}.0 - 0.5;
    vec2 uv = vUv + uTexel * tap;
    float depth = texture2D(uDepth, uv).r;
    if (depth < 1.0) gl_FragColor += vec4(clamp(deep(eyeOf(uv, depth)), -8.0, 8.0), 1.0, tap);
  }
  gl_FragColor /= ${kTaps * kTaps}.0;
}`;

const kBlurShader = `
uniform sampler2D uOf;
uniform vec2 uTexel;
uniform vec2 uAlong;
void main() {
  gl_FragColor = vec4(0.0);
  float all = 0.0;
  for (int i = -${kTexels}; i <= ${kTexels}; i++) {
    float weight = exp(-0.22 * float(i * i));
    vec2 tap = float(i) * uAlong;
    vec4 of = texture2D(uOf, vUv + tap * uTexel);
    gl_FragColor += weight * vec4(of.xy, of.zw + of.y * tap);
    all += weight;
  }
  gl_FragColor /= all;
}`;

/// The share of light at a place of the static objects.  Nested, since a software renderer runs on
/// after a return.
export const kLightAt = `
${kDeep}
uniform bool uCues;
uniform sampler2D uAround;
uniform vec2 uTexel;
uniform vec2 uPixel;
uniform highp sampler2D uDepth;
uniform vec3 uToLamp;
uniform vec4 uNearEnd[${kNearEndBalls}];
float cavityAt(vec2 uv, vec3 eye) {
  vec4 around = texture2D(uAround, uv);
  float deeper = deep(eye) - around.x / max(around.y, 0.001);
  if (around.y < 0.99) {
    // Beside the background, what is around lies to one side: a slope is no cavity.
    vec2 aside = around.zw / max(around.y, 0.001);
    vec2 near = uv + uPixel * normalize(aside + 1e-6);
    float slope = deep(eyeOf(near, texture2D(uDepth, near).r)) - deep(eye);
    deeper += clamp(slope * length(uTexel * aside / uPixel), -0.3, 0.3);
  }
  return smoothstep(0.0, 0.11, deeper) * smoothstep(0.3, 0.7, around.y);
}
/// Between two balls each, the nearest that the ray to the lamp passes (after Quilez, "Capsule -
/// soft shadow"), and the nearest to the place itself.
float shadowAt(vec3 eye) {
  float shadow = 0.0;
  float contact = 0.0;
  for (int i = 0; i + 1 < ${kNearEndBalls}; i++) {
    vec3 to = uNearEnd[i + 1].xyz - uNearEnd[i].xyz;
    vec3 from = eye - uNearEnd[i].xyz;
    float along = dot(from, to);
    float up = dot(to, uToLamp);
    float length2 = dot(to, to);
    float share = clamp(along / length2, 0.0, 1.0);
    float radius = mix(uNearEnd[i].w, uNearEnd[i + 1].w, share);
    contact = max(contact, 1.0 - (length(from - share * to) - radius) / (0.02 * uSight + radius));
    float climb = dot(from, uToLamp);
    float passed = clamp((along - climb * up) / (length2 - up * up), 0.0, 1.0);
    float far = max(passed * up - climb, 0.001 * uSight);
    radius = mix(uNearEnd[i].w, uNearEnd[i + 1].w, passed);
    float beside = length(from + far * uToLamp - passed * to) - radius;
    float soft = smoothstep(0.5, -0.5, 4.0 * beside / far);
    shadow = max(shadow, soft * smoothstep(2.0, 0.2, far / uSight));
  }
  return 1.0 - (1.0 - 0.4 * shadow) * (1.0 - 0.35 * clamp(contact, 0.0, 1.0));
}
float lightAt(vec2 uv, float depth) {
  float light = 1.0;
  if (uCues && depth < 1.0) {
    vec3 eye = eyeOf(uv, depth);
    light = 1.0 - 0.45 * cavityAt(uv, eye);
    if (distance(eye, uNearEnd[0].xyz) < 3.0 * uSight) light *= 1.0 - shadowAt(eye);
  }
  return light;
}`;

function makeMean(): WebGLRenderTarget {
  return new WebGLRenderTarget(1, 1, {
    type: HalfFloatType,
    minFilter: LinearFilter,
    magFilter: LinearFilter,
    depthBuffer: false,
  });
}

export class DepthCues {
  /// For a shader with kLightAt.
  readonly uniforms = {
    uCues: {value: false},
    uToEye: {value: new Matrix4()},
    uMiddle: {value: 1},
    uSight: {value: 1},
    uAround: {value: null as Texture | null},
    uTexel: {value: new Vector2()}, // of uAround, as a share of the picture
    uPixel: {value: new Vector2()}, // likewise, of the depth
    uDepth: {value: null as Texture | null},
    uToLamp: {value: kToLamp},
    uNearEnd: {value: Array.from({length: kNearEndBalls}, () => new Vector4())},
  };
  private readonly gather = fullPicture(kGatherShader, {});
  private readonly blur = fullPicture(kBlurShader, {uOf: null, uAlong: null});
  private readonly means = [makeMean(), makeMean()] as const;
  private readonly canBe: boolean; // it can draw into its targets
  private readonly centre = new Vector3();

  constructor(private readonly renderer: WebGLRenderer) {
    const {extensions} = renderer;
    this.canBe = ["EXT_color_buffer_half_float", "EXT_color_buffer_float"].some((name) =>
      extensions.has(name),
    );
    const {uToEye, uMiddle, uSight, uDepth, uTexel} = this.uniforms;
    Object.assign(this.gather.material.uniforms, {uToEye, uMiddle, uSight, uDepth, uTexel});
    Object.assign(this.blur.material.uniforms, {uTexel});
    this.uniforms.uAround.value = this.means[0].texture;
  }

  /// Another scene is shown.
  setWork({centre, radiusM}: Ball): void {
    this.centre.set(...centre);
    this.uniforms.uSight.value = radiusM;
  }

  /// Before the static objects are copied.
  /// @param nearEnd  of the tool, in W: centres and radii; empty: there is no tool
  light(on: boolean, eye: PerspectiveCamera, nearEnd: readonly Vector4[]): void {
    const {uCues, uNearEnd} = this.uniforms;
    uCues.value = on && this.canBe;
    uNearEnd.value.forEach((ball, i) => {
      const of = nearEnd[i];
      if (!of) return void ball.set(i, 0, kBehindEyeM, 0);
      const {x, y, z} = new Vector3(of.x, of.y, of.z).applyMatrix4(eye.matrixWorldInverse);
      ball.set(x, y, z, of.w);
    });
  }

  /// The static objects have been drawn.
  /// @param height  of the picture [pixels]
  took(depth: Texture, eye: PerspectiveCamera, width: number, height: number): void {
    const {renderer, means, uniforms} = this;
    uniforms.uDepth.value = depth;
    if (!this.canBe) return;
    uniforms.uToEye.value.copy(eye.projectionMatrixInverse);
    uniforms.uMiddle.value = -this.centre.clone().applyMatrix4(eye.matrixWorldInverse).z;
    const perMetre = (0.5 * height * eye.projectionMatrix.elements[5]!) / uniforms.uMiddle.value;
    const texel = Math.max(2, (kAround * uniforms.uSight.value * perMetre) / kTexels);
    const [columns, rows] = [width, height].map((side) =>
      Math.min(kMostTexels, Math.ceil(side / texel)),
    ) as [number, number];
    for (const mean of means) mean.setSize(columns, rows);
    uniforms.uTexel.value.set(1 / columns, 1 / rows);
    uniforms.uPixel.value.set(1 / width, 1 / height);
    renderer.setRenderTarget(means[0]);
    renderer.render(this.gather, eye);
    const blur = this.blur.material.uniforms;
    [new Vector2(1, 0), new Vector2(0, 1)].forEach((along, i) => {
      blur.uOf!.value = means[i]!.texture;
      blur.uAlong!.value = along;
      renderer.setRenderTarget(means[1 - i]!);
      renderer.render(this.blur, eye);
    });
  }
}
