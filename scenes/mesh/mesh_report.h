#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// What is known about a mesh before a sphere tree is built over it; lengths in the mesh's unit.
struct MeshReport {
  std::size_t vertices = 0, triangles = 0;
  std::size_t components = 0;            ///< sets of triangles that share no vertex with each other
  std::size_t boundary_edges = 0;        ///< edges of one triangle
  std::size_t non_manifold_edges = 0;    ///< edges of more than two triangles
  std::size_t inconsistent_edges = 0;    ///< edges of two triangles that wind against each other
  std::size_t degenerate_triangles = 0;  ///< without area, or with a corner twice
  std::size_t duplicate_triangles = 0;   ///< with the same three corners as an earlier one
  std::size_t unused_vertices = 0;
  std::size_t non_finite_vertices = 0;
  std::size_t bad_triangles = 0;  ///< with an index of no vertex
  Vec3 box_min = Vec3::Zero(), box_max = Vec3::Zero();
  double area = 0.0;
  double volume = 0.0;  ///< enclosed; negative if the mesh is inside out; rough if it is open
  Vec3 centroid = Vec3::Zero();  ///< of the solid; of the surface if the mesh is not closed

  bool closed() const { return boundary_edges == 0; }
  bool manifold() const { return non_manifold_edges == 0; }
  bool oriented() const { return inconsistent_edges == 0; }
  bool solid() const { return closed() && manifold() && oriented(); }
  bool inside_out() const { return solid() && volume < 0.0; }

  /// Why the mesh cannot be rendered, with the remedy; empty if it can.
  std::string refusal;
  /// Defects that do not prevent rendering, each with what is done about it or how to repair it.
  std::vector<std::string> remarks;
};

MeshReport InspectMesh(const TriangleMesh& mesh);

/// Throws Error with the first vertex that is not finite, or triangle that names no vertex.  For
/// meshes of no file, of which InspectMesh speaks.
void CheckNumbers(const TriangleMesh& mesh);

}  // namespace palpate
