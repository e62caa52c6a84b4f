#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scenes/mesh/mesh_packet.h"

namespace palpate {

/// The polygons of a mesh file.  They are cut into triangles later, when all vertices are known.
struct Polygons {
  std::vector<Vec3> vertices;
  std::vector<std::uint32_t> corners;  ///< of all polygons, one after the other
  std::vector<std::uint32_t> ends;     ///< for each polygon, its end in `corners`
  std::vector<MeshGroup> groups;       ///< ranges of polygons, not of triangles

  std::uint32_t size() const { return static_cast<std::uint32_t>(ends.size()); }
  void Add(std::span<const std::uint32_t> polygon) {
    corners.insert(corners.end(), polygon.begin(), polygon.end());
    ends.push_back(static_cast<std::uint32_t>(corners.size()));
  }
};

/// Cuts each polygon, convex or not, into two triangles fewer than it has corners; one with two
/// corners or fewer gives none.  Throws Error if a polygon names a vertex that does not exist.
ImportedMesh TrianglesOf(Polygons&& polygons);

}  // namespace palpate
