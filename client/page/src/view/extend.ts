import {Color, Data3DTexture, type IUniform, type Material, Vector3} from "three";

/// What is added to a shader: functions, what `main` begins with, and texts of three.js by others.
interface More {
  readonly functions?: string;
  readonly main?: string;
  readonly at?: Readonly<Record<string, string>>;
}

/// The declaration of a uniform, by its value.
function declared(name: string, value: unknown): string {
  const one: unknown = Array.isArray(value) ? value[0] : value;
  const isVector = one instanceof Vector3 || one instanceof Color;
  const type = one instanceof Data3DTexture ? "highp sampler3D" : isVector ? "vec3" : "float";
  return `uniform ${type} ${name}${Array.isArray(value) ? `[${value.length}]` : ""};\n`;
}

/// Changes a material's shader, besides what has changed it already.
/// @param name      of the change: materials of the same changes share a program
/// @param uniforms  both shaders have them
/// @param varyings  "TYPE NAME", from the vertex to the fragment
export function extend(
  material: Material,
  name: string,
  uniforms: Readonly<Record<string, IUniform>>,
  varyings: readonly string[],
  vertex: More,
  fragment: More,
): void {
  const before = material.onBeforeCompile.bind(material);
  const key = material.customProgramCacheKey();
  const head =
    varyings.map((one) => `varying ${one};\n`).join("") +
    Object.entries(uniforms)
      .map(([of, {value}]) => declared(of, value))
      .join("");
  const add = (text: string, {functions = "", main = "", at = {}}: More): string =>
    Object.entries(at).reduce(
      (all, [place, by]) => all.replace(place, by),
      text.replace("void main() {", `${head}${functions}\nvoid main() {\n${main}`),
    );
  material.onBeforeCompile = (shader, renderer) => {
    before(shader, renderer);
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = add(shader.vertexShader, vertex);
    shader.fragmentShader = add(shader.fragmentShader, fragment);
  };
  material.customProgramCacheKey = () => `${name} ${key}`;
}
