/// Blocks of a solid, as the server says them (idl/solid.idl).

type Place = readonly [number, number, number];

/// The code of scenes/grid/surface_code.h.
/// @param vertices   from the block's beginning [spacings]
/// @param materials  of each triangle; one: of all
export function surfaceCode(
  vertices: readonly Place[],
  triangles: readonly Place[],
  materials: readonly number[] = [0],
): Uint8Array {
  const words = (values: readonly number[]): number[] => [
    ...new Uint8Array(Uint16Array.from(values).buffer),
  ];
  const indices = triangles.flat();
  return Uint8Array.from([
    ...words([vertices.length, 0, triangles.length]),
    ...vertices.flat().map((at) => Math.round((at + 2) * 21)),
    ...(vertices.length <= 256 ? indices : words(indices)),
    ...materials,
  ]);
}

/// A lattice round the test's box: 4 blocks of 16.8 mm along each axis, in steps of 0.1 mm.
export const kLattice = {
  origin_m: [-0.0336, -0.0336, -0.0336],
  spacing_m: 0.0021,
  blocks: [4, 4, 4],
};

export const solidBlock = (
  scene: string,
  block: number,
  change: number,
  surface: Uint8Array,
  {cut = true, serverRun = 1n, object = 0, removedMm3 = [] as readonly number[]} = {},
): object => ({
  ...{scene, object_index: object, block, change: BigInt(change), server_run: serverRun},
  ...{...kLattice, cut, surface, removed_mm3: removedMm3},
});

/// In the top of the test's box, where the lattice has this block: x from -16.8 mm to 0, y from 16.8 mm
/// to 33.6, z from 0 to 16.8.
export const kPitBlock = (2 * 4 + 3) * 4 + 1;

const kTop = (0.025 - 0.0168) / kLattice.spacing_m;

/// The eight blocks round that one, which are not cut: their part of the top closes the seam.
export function aroundPit(scene: string, change: number): object[] {
  const ranges = [
    [(0.0336 - 0.025) / kLattice.spacing_m, 8], // the box begins in the midst of the block
    [0, 8],
    [0, kTop],
  ] as const;
  return ranges.flatMap(([x0, x1], i) =>
    ranges.flatMap(([z0, z1], k) => {
      if (i === 1 && k === 1) return [];
      const corners: Place[] = [
        [x0, kTop, z0],
        [x0, kTop, z1],
        [x1, kTop, z1],
        [x1, kTop, z0],
      ];
      const surface = surfaceCode(corners, [
        [0, 1, 2],
        [0, 2, 3],
      ]);
      const block = kPitBlock + (i - 1) + 4 * 4 * (k - 1);
      return [solidBlock(scene, block, change, surface, {cut: false})];
    }),
  );
}

/// What is left of the box there: its top, and in it a pit of 12.6 mm by 12.6 whose walls are of material 1.
export function pit(depthM = 0.007): Uint8Array {
  const corner = [
    [0, 0],
    [1, 0],
    [1, 1],
    [0, 1],
  ] as const;
  const square = (low: number, high: number, y: number): Place[] =>
    corner.map(([x, z]) => [x ? high : low, y, z ? high : low]);
  const vertices = [
    ...square(0, 8, kTop),
    ...square(1, 7, kTop),
    ...square(1, 7, kTop - depthM / kLattice.spacing_m),
  ];
  /// Between a square and the next one.
  const ring = (first: number): Place[] =>
    [0, 1, 2, 3].flatMap((i): Place[] => {
      const next = (i + 1) % 4;
      return [
        [first + i, first + 4 + i, first + next],
        [first + next, first + 4 + i, first + 4 + next],
      ];
    });
  const floor: Place[] = [
    [8, 11, 10],
    [8, 10, 9],
  ];
  const triangles = [...ring(0), ...ring(4), ...floor];
  return surfaceCode(
    vertices,
    triangles,
    triangles.map((_, t) => (t < 8 ? 0 : 1)),
  );
}
