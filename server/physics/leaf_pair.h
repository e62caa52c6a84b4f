#pragma once

#include <cstdint>

#include "server/physics/simd/kernels.h"

namespace palpate {

/// A pair of leaves, tool's and object's; the forest numbers the leaves of all objects together.
using LeafPair = NodePair;

/// The object leaf that a row's pair belongs to: its material is the row's.
inline std::int32_t ObjectLeafOf(const LeafPair& pair) {
  return pair.object;
}

}  // namespace palpate
