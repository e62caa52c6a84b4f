#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/mesh_query.h"
#include "scenes/scene.h"

namespace palpate {

/// Finds where a mesh's surface lies inside its own solid, so that nothing can touch it from
/// outside: gum inside a crown, or a part that passes through another.  Set-up only.
class HiddenSurface {
 public:
  /// @param mesh  must outlive this, be finite and oriented (mesh_orient.h).
  explicit HiddenSurface(const TriangleMesh& mesh);

  /// Returns whether both sides of the triangle are solid near the point, by the winding number.
  /// Near the holes of an open mesh there is no sharp answer.
  /// @param near  a point of the triangle.
  bool At(std::uint32_t triangle, const Vec3& near) const;
  /// Returns at how many of four places in a part of the triangle it is hidden: the part's middle,
  /// and near its corners.
  int Places(std::uint32_t triangle, const std::array<Vec3, 3>& part) const;
  static constexpr int kAllPlaces = 4;
  /// False if nothing can be hidden: the mesh is one closed piece that does not intersect itself.
  bool possible() const { return possible_; }
  bool closed() const { return closed_; }
  /// The same as At, at the point of the triangle that is nearest to p.
  bool NearestTo(std::uint32_t triangle, const Vec3& p) const;

 private:
  bool HiddenAt(std::uint32_t triangle, const Vec3& p) const;

  const TriangleMesh& mesh_;
  MeshQuery query_;
  bool closed_, possible_;
};

/// The surface that a mesh hides inside itself.
struct HiddenParts {
  /// hidden share of the surface, 0 to 1, estimated from a few points per triangle
  double share = 0.0;
  Vec3 at = Vec3::Zero();       ///< a hidden point, in the mesh's unit
  std::vector<std::string> of;  ///< names of the parts that have hidden surface, each once
};

/// @param groups  the mesh's named parts; may be empty.
HiddenParts FindHiddenParts(const TriangleMesh& mesh, const std::vector<MeshGroup>& groups = {});

/// Returns a sentence for people: "4.1 % of the surface lies inside ..."; empty if
/// nothing is hidden.
/// @param scale, unit  factor from the mesh's numbers to the unit to write, and its name, as "mm".
std::string HiddenRemark(const HiddenParts& hidden, double scale, const std::string& unit);

}  // namespace palpate
