#pragma once

#include <cstdint>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// An edge of one triangle only, which runs along it that way.
struct OpenEdge {
  std::uint32_t from, to, triangle;
};

/// In no particular order, but always the same.  Triangles with a corner twice have no edges.
std::vector<OpenEdge> OpenEdges(const TriangleMesh& mesh);

}  // namespace palpate
