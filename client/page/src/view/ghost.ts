import {
  BufferGeometry,
  Color,
  GreaterDepth,
  Group,
  Mesh,
  ShaderMaterial,
  type ShaderMaterialParameters,
} from "three";

const kVertexShader = `
varying vec3 vNormal;
varying vec3 vEye;
void main() {
  vec4 eye = modelViewMatrix * vec4(position, 1.0);
  vNormal = normalMatrix * normal;
  vEye = -eye.xyz;
  gl_Position = projectionMatrix * eye;
}`;

// A rim that fades towards the middle, so that the inside stays readable.
const kFragmentShader = `
uniform vec3 uColour;
uniform float uRim;
uniform float uBody;
varying vec3 vNormal;
varying vec3 vEye;
void main() {
  float facing = abs(dot(normalize(vNormal), normalize(vEye)));
  float rim = pow(1.0 - facing, 2.0);
  gl_FragColor = vec4(uColour, uBody + uRim * rim);
  #include <colorspace_fragment>
}`;

/// Distances of the hand from the graphic tool over which the ghost fades in [m].
const kAppearsM = [0.0001, 0.001] as const;

/// Transparent, and clearer in the middle than at the rim.
export const makeRim = (more: ShaderMaterialParameters): ShaderMaterial =>
  new ShaderMaterial({
    vertexShader: kVertexShader,
    fragmentShader: kFragmentShader,
    uniforms: {uColour: {value: new Color()}, uRim: {value: 0}, uBody: {value: 0}},
    transparent: true,
    ...more,
  });

/// The tool at the hand's pose: transparent, and fainter where it is hidden.  Invisible while the
/// hand and the graphic tool coincide.
export class Ghost {
  readonly group = new Group();
  private readonly materials: readonly ShaderMaterial[];

  constructor(geometry: BufferGeometry) {
    const depthOnly = makeRim({colorWrite: false});
    const seen = makeRim({depthWrite: false});
    const hidden = makeRim({depthWrite: false, depthFunc: GreaterDepth});
    this.materials = [seen, hidden];
    // The hidden parts first, then the front's depth, then the visible parts: no layer twice.
    [hidden, depthOnly, seen].forEach((material, order) => {
      const mesh = new Mesh(geometry, material);
      mesh.renderOrder = 1 + order;
      this.group.add(mesh);
    });
  }

  paint(colour: Color): void {
    for (const material of this.materials) (material.uniforms.uColour!.value as Color).copy(colour);
  }

  /// @param distanceM  of the hand from the graphic tool, with rotation counted at its lever arm
  setDistance(distanceM: number): void {
    const [from, to] = kAppearsM;
    const t = Math.min(1, Math.max(0, (distanceM - from) / (to - from)));
    this.group.visible = t > 0;
    const [seen, hidden] = this.materials;
    seen!.uniforms.uRim!.value = 0.8 * t;
    seen!.uniforms.uBody!.value = 0.1 * t;
    hidden!.uniforms.uRim!.value = 0.22 * t;
    hidden!.uniforms.uBody!.value = 0.02 * t;
  }

  dispose(): void {
    for (const mesh of this.group.children) ((mesh as Mesh).material as ShaderMaterial).dispose();
  }
}
