#pragma once

#include <cstdint>

namespace palpate {

inline constexpr int kTreeArity = 8;

/// Eight sibling nodes as a structure of arrays: one SIMD register per coordinate.  A lane without
/// a node holds NaN in every float, so that every comparison with it is false, and -1 as child.
struct alignas(32) SpherePacket {
  float x[kTreeArity];  ///< node centres, tree frame [m]
  float y[kTreeArity];
  float z[kTreeArity];
  float radius[kTreeArity];  ///< [m], rounded up: the node contains all *leaf spheres* below it
  std::int32_t
      child[kTreeArity];  ///< packet index in the next level; in the last level, leaf index
};

}  // namespace palpate
