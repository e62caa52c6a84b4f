import {WebGLRenderer} from "three";

/// Names of software renderers in browsers.
const kSoftware = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/// Returns whether the browser draws without a graphics card.  Uses a separate canvas, because a
/// canvas's context is fixed when it is first requested.
export function drawsBySoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return false;
  const named = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER) as unknown;
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return kSoftware.test(String(name));
}

/// Opaque: the picture has its own background, so blending with the page is unnecessary.
/// @return undefined if the browser has no WebGL
export function makeRenderer(
  canvas: HTMLCanvasElement,
  antialias: boolean,
): WebGLRenderer | undefined {
  try {
    const renderer = new WebGLRenderer({canvas, antialias, alpha: false});
    renderer.info.autoReset = false;
    return renderer;
  } catch {
    return undefined;
  }
}
