#pragma once

#include <cstdint>

#include "server/physics/simd/kernels.h"

namespace palpate {

/// A pair of leaves, tool's and object's; the forest numbers the leaves of all objects together.
using LeafPair = NodePair;

/// What the pair of a row names: leaves, or, told by a tag added to `tool`, triangles of two meshes
/// (contact/touch_rows.h).
enum class RowKind : std::int32_t {
  kLeaves = 0,
  kMeshes = 1,  ///< triangles; the tool's number times four, plus which corner touches
};
inline constexpr int kRowKindShift = 28;
inline RowKind KindOf(const LeafPair& pair) {
  return static_cast<RowKind>(pair.tool >> kRowKindShift);
}

}  // namespace palpate
