import {
  Color,
  DepthTexture,
  LinearFilter,
  Matrix4,
  NearestFilter,
  type Object3D,
  type PerspectiveCamera,
  Vector2,
  type WebGLProgramParametersWithUniforms,
  type WebGLRenderer,
  WebGLRenderTarget,
} from "three";

import type {Drawn, InMotion} from "../model/quality";
import {DepthCues, kLightAt} from "./depth_cues";
import {fullPicture} from "./full_picture";
import type {Palette} from "./palette";

// Static objects are drawn once, with their depth, and copied under each picture: without a
// graphics card the mouth's 123,000 triangles cost ten times as much as the tool and the copy.

/// The camera is at rest if it has not moved for this long.
const kRestMs = 300;
const kSamples = 4;

// Like .picture in the style sheet, which shows if there is no WebGL.
const kBackgroundShader = `
uniform vec3 uGlow;
uniform vec3 uPaper;
void main() {
  float away = length((vUv - vec2(0.5, 0.58)) / vec2(0.75, 0.7));
  gl_FragColor = vec4(mix(uGlow, uPaper, min(away, 1.0)), 1.0);
}`;

const kCopyShader = `
${kLightAt}
uniform sampler2D uColour;
void main() {
  float depth = texture2D(uDepth, vUv).r;
  gl_FragColor = texture2D(uColour, vUv);
  gl_FragColor.rgb *= lightAt(vUv, depth);
  gl_FragDepth = depth;
}`;

/// Makes a material write sRGB also into the layer, since 8 bits of linear light would show steps.
/// For a material's onBeforeCompile.
export function paintForScreen(shader: WebGLProgramParametersWithUniforms): void {
  shader.fragmentShader = shader.fragmentShader.replace(
    "#include <colorspace_fragment>",
    "gl_FragColor = sRGBTransferOETF(gl_FragColor);",
  );
}

function makeSheet(
  samples: number,
  filter: typeof NearestFilter | typeof LinearFilter,
): WebGLRenderTarget {
  const depthTexture = new DepthTexture(1, 1);
  depthTexture.minFilter = depthTexture.magFilter = NearestFilter;
  return new WebGLRenderTarget(1, 1, {
    samples,
    depthTexture,
    minFilter: filter,
    magFilter: filter,
  });
}

/// Quality of a layer: full, or reduced while the camera moves.
export type Sheet = "whole" | "hurried";

/// What a picture does with the layer.
export interface Step {
  readonly sheet: Sheet; // the one that the picture shows
  readonly anew: boolean; // it is drawn first
  readonly drawn: Drawn;
}

export class StillLayer {
  /// To be drawn with the static objects, and with the moving ones.
  readonly background = fullPicture(kBackgroundShader, {uGlow: new Color(), uPaper: new Color()});
  readonly copy = fullPicture(kCopyShader, {uColour: null});
  readonly cues: DepthCues;

  private readonly whole = makeSheet(kSamples, NearestFilter);
  private readonly hurried = makeSheet(0, LinearFilter); // while the camera moves
  private shows: "nothing" | Sheet = "nothing";
  private stale = true;
  private changedMs = -Infinity;
  private readonly seenFrom = new Matrix4();
  private readonly projection = new Matrix4();

  constructor(private readonly renderer: WebGLRenderer) {
    this.cues = new DepthCues(renderer);
    Object.assign(this.copy.material.uniforms, this.cues.uniforms);
    this.background.material.depthWrite = false;
  }

  paint({glow, paper}: Palette): void {
    const {uGlow, uPaper} = this.background.material.uniforms;
    (uGlow!.value as Color).copy(glow).convertLinearToSRGB();
    (uPaper!.value as Color).copy(paper).convertLinearToSRGB();
    this.restart();
  }

  /// A static object has changed.
  change(): void {
    this.stale = true;
  }
  /// Everything has changed, and must not be shown at reduced quality.
  restart(): void {
    this.stale = true;
    this.shows = "nothing";
  }

  /// Redraws the layer if it is out of date, and at full quality if it is reduced and the camera
  /// has come to rest.
  next(eye: PerspectiveCamera, nowMs: number, inMotion: InMotion): Step {
    const {shows} = this;
    if (this.hasChanged(eye)) {
      this.changedMs = nowMs;
      if (shows === "nothing") return {sheet: "whole", anew: true, drawn: "else"};
      return {sheet: inMotion.samples > 0 ? "whole" : "hurried", anew: true, drawn: "objects"};
    }
    if (this.settlesInMs(nowMs) === 0) return {sheet: "whole", anew: true, drawn: "else"};
    // With a reduced canvas, a picture's time tells nothing about its cost at rest.
    return shows === "hurried"
      ? {sheet: "hurried", anew: false, drawn: "else"}
      : {sheet: "whole", anew: false, drawn: "tools"};
  }

  /// @param share  of the canvas's pixels, per side
  draw(scene: Object3D, eye: PerspectiveCamera, how: Sheet, share: number): void {
    const sheet = this[how];
    const {x, y} = this.renderer.getDrawingBufferSize(new Vector2());
    sheet.setSize(Math.ceil(share * x), Math.ceil(share * y));
    this.renderer.setRenderTarget(sheet);
    this.renderer.render(scene, eye);
    this.cues.took(sheet.depthTexture!, eye, sheet.width, sheet.height);
    this.renderer.setRenderTarget(null);
    this.copy.material.uniforms.uColour!.value = sheet.texture;
    this.shows = how;
  }

  /// Returns when the camera will be at rest and a better layer is due; undefined: it is
  /// at its best.
  settlesInMs(nowMs: number): number | undefined {
    if (this.shows !== "hurried") return undefined;
    return Math.max(0, this.changedMs + kRestMs - nowMs);
  }

  private hasChanged(eye: PerspectiveCamera): boolean {
    eye.updateMatrixWorld();
    const same =
      !this.stale &&
      this.seenFrom.equals(eye.matrixWorld) &&
      this.projection.equals(eye.projectionMatrix);
    if (same) return false;
    this.stale = false;
    this.seenFrom.copy(eye.matrixWorld);
    this.projection.copy(eye.projectionMatrix);
    return true;
  }
}
