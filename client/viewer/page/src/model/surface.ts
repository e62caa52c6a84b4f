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
const kAll = -2; // less than any cosine

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
  const surelySmooth = Math.cos((kCreaseDeg * Math.PI) / 360);
  const normal: [number, number, number] = [0, 0, 0];
  const add = (v: number): void => {
    source.push(v);
    positions.push(vertices[3 * v]!, vertices[3 * v + 1]!, vertices[3 * v + 2]!);
    normals.push(normal[0], normal[1], normal[2]);
  };
  for (let v = 0; v + 1 < begin.length; v++) {
    const first = source.length;
    const around = cornersOf.subarray(begin[v]!, begin[v + 1]!);
    if (around.length === 0) continue;
    // Most vertices: all faces lie within half the angle of their mean, so no two make an edge.
    average(faceNormals, weights, around, kAll, around[0]!, normal);
    if (allWithin(faceNormals, around, normal, surelySmooth)) {
      for (const corner of around) index[corner] = first;
      add(v);
      continue;
    }
    for (const corner of around) {
      average(faceNormals, weights, around, crease, corner, normal);
      let k = first;
      while (k < source.length && !closeTo(normals, k, normal)) k += 1;
      if (k === source.length) add(v);
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

/// Face normals and corner angles of the triangle whose first corner is t.
function measure(
  vertices: Float32Array,
  triangles: Uint32Array,
  t: number,
  faceNormals: Float32Array,
  weights: Float32Array,
): void {
  const a = 3 * triangles[t]!;
  const b = 3 * triangles[t + 1]!;
  const c = 3 * triangles[t + 2]!;
  const ux = vertices[b]! - vertices[a]!;
  const uy = vertices[b + 1]! - vertices[a + 1]!;
  const uz = vertices[b + 2]! - vertices[a + 2]!;
  const vx = vertices[c]! - vertices[a]!;
  const vy = vertices[c + 1]! - vertices[a + 1]!;
  const vz = vertices[c + 2]! - vertices[a + 2]!;
  const x = uy * vz - uz * vy;
  const y = uz * vx - ux * vz;
  const z = ux * vy - uy * vx;
  const length = Math.sqrt(x * x + y * y + z * z);
  if (length > 0) {
    faceNormals[t] = x / length;
    faceNormals[t + 1] = y / length;
    faceNormals[t + 2] = z / length;
  }
  const uv = ux * vx + uy * vy + uz * vz;
  const uu = ux * ux + uy * uy + uz * uz;
  const vv = vx * vx + vy * vy + vz * vz;
  weights[t] = Math.atan2(length, uv);
  weights[t + 1] = Math.atan2(length, uu - uv);
  weights[t + 2] = Math.atan2(length, vv - uv);
}

/// Mean of the faces around a vertex whose cosine with the corner's own is at least `cosine`,
/// weighted by their angles there.
function average(
  faceNormals: Float32Array,
  weights: Float32Array,
  around: Uint32Array,
  cosine: number,
  corner: number,
  out: [number, number, number],
): void {
  const own = corner - (corner % 3);
  const nx = faceNormals[own]!;
  const ny = faceNormals[own + 1]!;
  const nz = faceNormals[own + 2]!;
  let x = 0;
  let y = 0;
  let z = 0;
  for (const other of around) {
    const t = other - (other % 3);
    const ox = faceNormals[t]!;
    const oy = faceNormals[t + 1]!;
    const oz = faceNormals[t + 2]!;
    if (nx * ox + ny * oy + nz * oz < cosine) continue;
    const weight = weights[other]!;
    x += weight * ox;
    y += weight * oy;
    z += weight * oz;
  }
  const length = Math.sqrt(x * x + y * y + z * z) || 1;
  out[0] = x / length;
  out[1] = y / length;
  out[2] = z / length;
}

function allWithin(
  faceNormals: Float32Array,
  around: Uint32Array,
  normal: readonly [number, number, number],
  cosine: number,
): boolean {
  for (const corner of around) {
    const t = corner - (corner % 3);
    const along =
      normal[0] * faceNormals[t]! +
      normal[1] * faceNormals[t + 1]! +
      normal[2] * faceNormals[t + 2]!;
    if (along < cosine) return false;
  }
  return true;
}

function closeTo(
  normals: readonly number[],
  k: number,
  normal: readonly [number, number, number],
): boolean {
  const dot =
    normals[3 * k]! * normal[0] + normals[3 * k + 1]! * normal[1] + normals[3 * k + 2]! * normal[2];
  return dot > 0.9995;
}
