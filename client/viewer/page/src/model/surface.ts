/// A mesh as a graphics card wants it: one normal a vertex, vertices split along creases, so that
/// round things are smooth and edges stay sharp.  Triangles keep their places.
export interface Surface {
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  readonly index: Uint32Array;
  readonly source: Uint32Array; // of each vertex: which of the mesh's it is
}

/// Faces that meet at more than this are an edge.
const kCreaseDeg = 40;

export function makeSurface(vertices: Float32Array, triangles: Uint32Array): Surface {
  const corners = triangles.length;
  const faceNormals = new Float32Array(corners); // by triangle, unit
  const weights = new Float32Array(corners); // by corner: the angle there
  for (let t = 0; t < corners; t += 3) measure(vertices, triangles, t, faceNormals, weights);

  // The corners at each vertex, as a list of lists in two arrays.
  const begin = new Uint32Array(vertices.length / 3 + 1);
  for (const v of triangles) begin[v + 1]! += 1;
  for (let v = 1; v < begin.length; v++) begin[v]! += begin[v - 1]!;
  const next = begin.slice();
  const cornersOf = new Uint32Array(corners);
  for (let c = 0; c < corners; c++) cornersOf[next[triangles[c]!]!++] = c;

  const positions: number[] = [];
  const normals: number[] = [];
  const source: number[] = [];
  const index = new Uint32Array(corners);
  const crease = Math.cos((kCreaseDeg * Math.PI) / 180);
  const normal: [number, number, number] = [0, 0, 0];
  for (let v = 0; v + 1 < begin.length; v++) {
    const first = source.length;
    for (let i = begin[v]!; i < begin[v + 1]!; i++) {
      const corner = cornersOf[i]!;
      averageAcross(
        faceNormals,
        weights,
        cornersOf.subarray(begin[v]!, begin[v + 1]!),
        corner,
        crease,
        normal,
      );
      let k = first;
      while (k < source.length && !closeTo(normals, k, normal)) k += 1;
      if (k === source.length) {
        source.push(v);
        positions.push(vertices[3 * v]!, vertices[3 * v + 1]!, vertices[3 * v + 2]!);
        normals.push(...normal);
      }
      index[corner] = k;
    }
  }
  return {
    positions: Float32Array.from(positions),
    normals: Float32Array.from(normals),
    index,
    source: Uint32Array.from(source),
  };
}

function measure(
  vertices: Float32Array,
  triangles: Uint32Array,
  t: number,
  faceNormals: Float32Array,
  weights: Float32Array,
): void {
  const at = (corner: number, axis: number): number => vertices[3 * triangles[t + corner]! + axis]!;
  const side = (from: number, to: number): [number, number, number] => [
    at(to, 0) - at(from, 0),
    at(to, 1) - at(from, 1),
    at(to, 2) - at(from, 2),
  ];
  const u = side(0, 1);
  const v = side(0, 2);
  const w = side(1, 2);
  const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(n[0]!, n[1]!, n[2]!);
  if (length > 0) for (let axis = 0; axis < 3; axis++) faceNormals[t + axis] = n[axis]! / length;
  const dot = (a: readonly number[], b: readonly number[]): number =>
    a[0]! * b[0]! + a[1]! * b[1]! + a[2]! * b[2]!;
  weights[t] = Math.atan2(length, dot(u, v));
  weights[t + 1] = Math.atan2(length, -dot(u, w));
  weights[t + 2] = Math.atan2(length, dot(v, w));
}

/// Mean of the faces around a vertex that make no edge with the corner's own.
function averageAcross(
  faceNormals: Float32Array,
  weights: Float32Array,
  around: Uint32Array,
  corner: number,
  crease: number,
  out: [number, number, number],
): void {
  const own = corner - (corner % 3);
  const [nx, ny, nz] = [faceNormals[own]!, faceNormals[own + 1]!, faceNormals[own + 2]!];
  let x = 0;
  let y = 0;
  let z = 0;
  for (const other of around) {
    const t = other - (other % 3);
    const [ox, oy, oz] = [faceNormals[t]!, faceNormals[t + 1]!, faceNormals[t + 2]!];
    if (nx * ox + ny * oy + nz * oz < crease) continue;
    const weight = weights[other]!;
    x += weight * ox;
    y += weight * oy;
    z += weight * oz;
  }
  const length = Math.hypot(x, y, z) || 1;
  out[0] = x / length;
  out[1] = y / length;
  out[2] = z / length;
}

function closeTo(normals: readonly number[], k: number, normal: readonly number[]): boolean {
  const dot =
    normals[3 * k]! * normal[0]! +
    normals[3 * k + 1]! * normal[1]! +
    normals[3 * k + 2]! * normal[2]!;
  return dot > 0.9995;
}
