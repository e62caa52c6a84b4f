import {WebGLRenderer} from "three";

/// What browsers call the drawing of a processor.
const kSoftware = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/// Whether the browser draws without a graphics card.  Asked of a canvas of its own: what a picture's
/// canvas can do is settled when it is first asked for.
export function drawsBySoftware(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return false;
  const named = gl.getExtension("WEBGL_debug_renderer_info");
  const name = gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER) as unknown;
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return kSoftware.test(String(name));
}

/// Opaque: the picture has its own background, and the page need not be mixed with it.
/// @return undefined where the browser has no WebGL
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
