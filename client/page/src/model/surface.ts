/// A mesh for the graphics card: one normal per vertex; vertices are split along creases, so that
/// round parts are smooth and edges stay sharp.  Triangles keep their order.
export interface Surface {
  readonly positions: Float32Array;
  readonly normals: Float32Array;
  readonly index: Uint32Array;
  readonly source: Uint32Array; // for each vertex, its index in the mesh
}

export interface Faces {
  readonly faceNormals: Float32Array; // unit normals, by triangle
  readonly weights: Float32Array; // for each corner, the angle there
}

export interface Part {
  // number of corners wanted, the first ones; others only contribute to normals
  readonly own: number;
  readonly kinds: Uint8Array; // for each triangle; two kinds always meet in a sharp edge
  readonly faces: Faces;
}

/// Faces that meet at a larger angle form an edge.
const kCreaseDeg = 40;
/// More similar normals are merged.
const kSameCosine = 0.9995;

/// @param part  a part of a larger mesh; if left out, all of the mesh is wanted
export function makeSurface(
  vertices: Float32Array | Float64Array,
  triangles: Uint32Array,
  part?: Part,
): Surface {
  const corners = triangles.length;
  const {own: wanted, kinds} = part ?? {own: corners, kinds: undefined};
  const {faceNormals, weights} = part?.faces ?? measure(vertices, triangles);

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
  const kindOf: number[] = []; // likewise
  const index = new Uint32Array(wanted);
  const crease = Math.cos((kCreaseDeg * Math.PI) / 180);
  for (let v = 0; v + 1 < begin.length; v++) {
    const first = source.length;
    const end = begin[v + 1]!;
    for (let i = begin[v]!; i < end; i++) {
      const corner = cornersOf[i]!;
      if (corner >= wanted) continue;
      // The mean normal of the faces that form no edge with the corner's own, weighted by
      // their angles here.
      const own = corner - (corner % 3);
      const kind = kinds?.[own / 3] ?? 0;
      const ownX = faceNormals[own]!;
      const ownY = faceNormals[own + 1]!;
      const ownZ = faceNormals[own + 2]!;
      let x = 0;
      let y = 0;
      let z = 0;
      for (let j = begin[v]!; j < end; j++) {
        const other = cornersOf[j]!;
        const face = other - (other % 3);
        if (kinds && kinds[face / 3] !== kind) continue;
        const faceX = faceNormals[face]!;
        const faceY = faceNormals[face + 1]!;
        const faceZ = faceNormals[face + 2]!;
        if (ownX * faceX + ownY * faceY + ownZ * faceZ < crease) continue;
        const weight = weights[other]!;
        x += weight * faceX;
        y += weight * faceY;
        z += weight * faceZ;
      }
      const length = Math.sqrt(x * x + y * y + z * z) || 1;
      x /= length;
      y /= length;
      z /= length;
      let k = first;
      while (
        k < source.length &&
        (kindOf[k] !== kind ||
          normals[3 * k]! * x + normals[3 * k + 1]! * y + normals[3 * k + 2]! * z <= kSameCosine)
      ) {
        k += 1;
      }
      if (k === source.length) {
        source.push(v);
        kindOf.push(kind);
        positions.push(vertices[3 * v]!, vertices[3 * v + 1]!, vertices[3 * v + 2]!);
        normals.push(x, y, z);
      }
      index[corner] = k;
    }
  }
  return {
    positions: new Float32Array(positions),
    normals: new Float32Array(normals),
    index,
    source: new Uint32Array(source),
  };
}

export function measure(vertices: Float32Array | Float64Array, triangles: Uint32Array): Faces {
  const faceNormals = new Float32Array(triangles.length);
  const weights = new Float32Array(triangles.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t]!;
    const b = 3 * triangles[t + 1]!;
    const c = 3 * triangles[t + 2]!;
    const abX = vertices[b]! - vertices[a]!;
    const abY = vertices[b + 1]! - vertices[a + 1]!;
    const abZ = vertices[b + 2]! - vertices[a + 2]!;
    const acX = vertices[c]! - vertices[a]!;
    const acY = vertices[c + 1]! - vertices[a + 1]!;
    const acZ = vertices[c + 2]! - vertices[a + 2]!;
    const x = abY * acZ - abZ * acY;
    const y = abZ * acX - abX * acZ;
    const z = abX * acY - abY * acX;
    const area = Math.sqrt(x * x + y * y + z * z);
    const atA = abX * acX + abY * acY + abZ * acZ;
    const atB = abX * abX + abY * abY + abZ * abZ - atA;
    const atC = acX * acX + acY * acY + acZ * acZ - atA;
    weights[t] = Math.atan2(area, atA);
    weights[t + 1] = Math.atan2(area, atB);
    weights[t + 2] = Math.atan2(area, atC);
    const length = area || 1;
    faceNormals[t] = x / length;
    faceNormals[t + 1] = y / length;
    faceNormals[t + 2] = z / length;
  }
  return {faceNormals, weights};
}
