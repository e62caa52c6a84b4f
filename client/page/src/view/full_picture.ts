import {AlwaysDepth, Mesh, PlaneGeometry, ShaderMaterial} from "three";

// It fills the picture, whatever the camera.
const kVertexShader = `
varying vec2 vUv;
void main() {
  vUv = uv;
  gl_Position = vec4(position.xy, 1.0, 1.0);
}`;

export type FullPicture = Mesh<PlaneGeometry, ShaderMaterial>;

/// @param uniforms  their values
export function fullPicture(
  fragmentShader: string,
  uniforms: Record<string, unknown>,
): FullPicture {
  const material = new ShaderMaterial({
    vertexShader: kVertexShader,
    fragmentShader: `varying vec2 vUv;\n${fragmentShader}`,
    uniforms: Object.fromEntries(Object.entries(uniforms).map(([name, value]) => [name, {value}])),
    depthFunc: AlwaysDepth,
  });
  const mesh = new Mesh(new PlaneGeometry(2, 2), material);
  mesh.frustumCulled = false;
  mesh.renderOrder = -1; // before everything else
  return mesh;
}
