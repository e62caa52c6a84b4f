#pragma once

#include <cstdint>

namespace palpate {

inline constexpr int kTreeArity = 8;

/// Eight sibling nodes as a structure of arrays: one SIMD register per coordinate.  Lanes without a
/// node hold NaN in every float, so that no comparison with them is ever true, and -1 as child.
struct alignas(32) SpherePacket {
  float x[kTreeArity];  ///< node centres, tree frame [m]
  float y[kTreeArity];
  float z[kTreeArity];
  float radius[kTreeArity];  ///< [m], rounded up: the node holds all *leaf spheres* below it
  std::int32_t
      child[kTreeArity];  ///< packet index in the next level; in the last level, leaf index
};

}  // namespace palpate
