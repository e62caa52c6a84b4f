#pragma once

#include <cstdint>

#include "server/physics/simd/kernels.h"

namespace palpate {

/// A pair of leaves, tool's and object's; the forest numbers the leaves of all objects together.
using LeafPair = NodePair;

/// What the pair of a row names: leaves, or, told by a tag added to `tool`, parts of two surfaces
/// (rows/surface_prediction.h).
enum class RowKind : std::int32_t {
  kLeaves = 0,
  kPointOnPatch = 1,  ///< a point of the tool on a patch of an object
  kPatchOnPoint = 2,
  kCreases = 3,
  kBallOnCrease = 4,  ///< a spherical tool on a crease of an object
};
inline constexpr int kRowKindShift = 28;
inline RowKind KindOf(const LeafPair& pair) {
  return static_cast<RowKind>(pair.tool >> kRowKindShift);
}
inline LeafPair Untagged(const LeafPair& pair) {
  return {pair.tool & ((1 << kRowKindShift) - 1), pair.object};
}

}  // namespace palpate
