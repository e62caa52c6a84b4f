import {Vector3} from "three";

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
/// Normals that are nearer to each other are one.
const kSameCosine = 0.9995;

export function makeSurface(vertices: Float32Array, triangles: Uint32Array): Surface {
  const corners = triangles.length;
  const {faceNormals, weights} = measure(vertices, triangles);

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
  const [own, face, normal] = [new Vector3(), new Vector3(), new Vector3()];
  const faceOf = (corner: number): number => corner - (corner % 3);
  for (let v = 0; v + 1 < begin.length; v++) {
    const first = source.length;
    const around = cornersOf.subarray(begin[v]!, begin[v + 1]!);
    for (const corner of around) {
      // The mean, by their angles here, of the faces that make no edge with the corner's own.
      own.fromArray(faceNormals, faceOf(corner));
      normal.set(0, 0, 0);
      for (const other of around) {
        face.fromArray(faceNormals, faceOf(other));
        if (own.dot(face) >= crease) normal.addScaledVector(face, weights[other]!);
      }
      normal.normalize();
      let k = first;
      while (k < source.length && face.fromArray(normals, 3 * k).dot(normal) <= kSameCosine) k += 1;
      if (k === source.length) {
        source.push(v);
        positions.push(vertices[3 * v]!, vertices[3 * v + 1]!, vertices[3 * v + 2]!);
        normals.push(normal.x, normal.y, normal.z);
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

/// Unit normals by triangle, and by corner the angle there.
function measure(
  vertices: Float32Array,
  triangles: Uint32Array,
): {faceNormals: Float32Array; weights: Float32Array} {
  const faceNormals = new Float32Array(triangles.length);
  const weights = new Float32Array(triangles.length);
  const [a, b, c, ab, bc, ca] = Array.from({length: 6}, () => new Vector3()) as [
    ...[Vector3, Vector3, Vector3],
    ...[Vector3, Vector3, Vector3],
  ];
  for (let t = 0; t < triangles.length; t += 3) {
    [a, b, c].forEach((corner, i) => corner.fromArray(vertices, 3 * triangles[t + i]!));
    ab.subVectors(b, a);
    bc.subVectors(c, b);
    ca.subVectors(a, c);
    weights[t] = Math.PI - ab.angleTo(ca);
    weights[t + 1] = Math.PI - bc.angleTo(ab);
    weights[t + 2] = Math.PI - ca.angleTo(bc);
    ab.cross(bc).normalize().toArray(faceNormals, t);
  }
  return {faceNormals, weights};
}
