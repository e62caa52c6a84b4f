import type {IUniform, Material, WebGLProgramParametersWithUniforms} from "three";

/// Changes a material's shader, besides what has changed it already.
/// @param name  of the change: materials of the same changes share a program
export function extend(
  material: Material,
  name: string,
  uniforms: Readonly<Record<string, IUniform>>,
  more: (shader: WebGLProgramParametersWithUniforms) => void,
): void {
  const before = material.onBeforeCompile.bind(material);
  const key = material.customProgramCacheKey();
  material.onBeforeCompile = (shader, renderer) => {
    before(shader, renderer);
    Object.assign(shader.uniforms, uniforms);
    more(shader);
  };
  material.customProgramCacheKey = () => `${name} ${key}`;
}
