import {BufferAttribute} from "three";

import type {Surface} from "../model/surface";

/// Fewer triangles over the same vertices, for machines that cannot draw all of them while the eye
/// moves; the library comes only where that is so.
/// @param distancesM  how far each of them may be from the surface, from fine to coarse
export async function coarsen(
  surface: Surface,
  distancesM: readonly number[],
): Promise<BufferAttribute[]> {
  const {MeshoptSimplifier: simplifier} = await import("meshoptimizer/simplifier");
  await simplifier.ready;
  let index = surface.index;
  return distancesM.map((distance) => {
    [index] = simplifier.simplify(index, surface.positions, 3, 0, distance, ["ErrorAbsolute"]);
    return new BufferAttribute(index, 1);
  });
}
