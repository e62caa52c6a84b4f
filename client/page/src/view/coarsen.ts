import {BufferAttribute} from "three";

import type {Surface} from "../model/surface";

/// Makes fewer triangles over the same vertices, for machines that cannot draw all of them while
/// the camera moves; the library is loaded only then.
/// @param distancesM  largest errors of the coarser surfaces, from fine to coarse
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
