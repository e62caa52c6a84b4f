#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scenes/mesh/mesh_packet.h"

namespace palpate {

/// What a mesh file says, before its polygons are cut into triangles: only then are all corners
/// known.
struct Polygons {
  std::vector<Vec3> vertices;
  std::vector<std::uint32_t> corners;  ///< of one polygon after the other
  std::vector<std::uint32_t> ends;     ///< of each polygon, in `corners`
  std::vector<MeshGroup> groups;       ///< of polygons, not of triangles

  std::uint32_t size() const { return static_cast<std::uint32_t>(ends.size()); }
  void Add(std::span<const std::uint32_t> polygon) {
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    ends.push_back(static_cast<std::uint32_t>(corners.size()));
  }
};

/// Cuts each polygon, convex or not, into two triangles fewer than it has corners; of one with two
/// corners or fewer nothing is left.  Throws Error where one names a vertex that is not there.
ImportedMesh TrianglesOf(Polygons&& polygons);

}  // namespace palpate
