#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/mesh_query.h"
#include "scenes/scene.h"

namespace palpate {

/// Tells where a mesh's surface lies inside its own solid: gum inside a crown, a part that goes
/// through another.  Nothing from outside touches it there.  Set-up only.
class HiddenSurface {
 public:
  /// @param mesh  must outlive this, with finite numbers and oriented (mesh_orient.h).
  explicit HiddenSurface(const TriangleMesh& mesh);

  /// Whether the triangle has solid on both sides near the point, by the winding number; near the
  /// holes of an open mesh that is a matter of degree.
  /// @param near  a point of the triangle.
  bool At(std::uint32_t triangle, const Vec3& near) const;
  /// At how many of four places of a part of the triangle it has: in the part's middle, and near
  /// its corners.
  int Places(std::uint32_t triangle, const std::array<Vec3, 3>& part) const;
  static constexpr int kAllPlaces = 4;
  /// False where nothing can be hidden: of one closed piece that does not pass through itself.
  bool possible() const { return possible_; }
  bool closed() const { return closed_; }
  /// The same, at the point of the triangle that is nearest to p.
  bool NearestTo(std::uint32_t triangle, const Vec3& p) const;

 private:
  bool HiddenAt(std::uint32_t triangle, const Vec3& p) const;

  const TriangleMesh& mesh_;
  MeshQuery query_;
  bool closed_, possible_;
};

/// What a mesh hides of itself.
struct HiddenParts {
  double share = 0.0;           ///< of the surface, 0 to 1; triangles are told by a few points each
  Vec3 at = Vec3::Zero();       ///< a hidden point, in the mesh's unit
  std::vector<std::string> of;  ///< named parts that have hidden surface, each once
};

/// @param groups  named parts of the mesh; may be empty.
HiddenParts FindHiddenParts(const TriangleMesh& mesh, const std::vector<MeshGroup>& groups = {});

/// For people: "4.1 % of the surface lies inside ..."; empty where nothing is hidden.
/// @param unit  of the mesh's numbers, as "mm", and what they are multiplied by for it.
std::string HiddenRemark(const HiddenParts& hidden, double scale, const std::string& unit);

}  // namespace palpate
