#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "scenes/grid/sparse_field.h"
#include "scenes/scene.h"

namespace palpate {

struct SolidGridOptions {
  double spacing = 50e-6;  ///< 25e-6 to 200e-6 [m]
  /// What the grid may take for as long as it lives [bytes].
  std::size_t most_bytes = 64u << 20;
  /// Below SolidGrid::kMaterials, for each point of B; none: all is of material 0.
  std::function<std::uint8_t(const Vec3& p_B)> material = nullptr;
};

/// A solid that can be cut: the signed distance to its mesh in a band of 3 h round the surface, at
/// the points of a lattice, and the material of each point that is solid.  It never changes, and
/// everybody may read it at once; what burs took away is a CutField beside it.
class SolidGrid {
 public:
  /// The band over the spacing: a point whose cell the surface crosses lies within sqrt(3) h of it,
  /// and its neighbours, of which the volume's gradient is made, within another h.
  static constexpr int kBandSpacings = 3;
  static constexpr int kMaterials = 8;

  /// Distances are those to the nearest triangle, whichever feature of it that is (exact but for
  /// the rounding to a float); the sign is how often the surface winds round the point, counted
  /// along a line through the lattice, and so right beside edges and corners and of every shell.
  /// Surface inside the solid (shells that overlap) counts as surface: the distance is small beside
  /// it. Deterministic.  Set-up: allocates, and takes some tenths of a second for a tooth.
  /// `mesh`: closed, oriented, in frame B [m]; `name`: of the body, for what is thrown.
  /// Throws Error, before the grid takes its memory, where the mesh is open, empty or inside out,
  /// or the grid would take more than it may.
  SolidGrid(const TriangleMesh& mesh, const SolidGridOptions& options, const std::string& name);

  const SparseField& field() const { return field_; }
  /// Real-time.
  FieldSample Sample(const Vec3& p_B) const noexcept { return field_.Sample(p_B); }
  /// Of the lattice's point nearest to p; 0 outside of the lattice.  Real-time.
  std::uint8_t Material(const Vec3& p_B) const noexcept;
  std::uint8_t MaterialOf(std::size_t block, int point) const {
    const std::int32_t entry = material_[block];
    return entry < 0 ? static_cast<std::uint8_t>(-1 - entry)
                     : mixed_[static_cast<std::size_t>(entry) * SparseField::kPoints +
                              static_cast<std::size_t>(point)];
  }
  /// Blocks that are not free throughout: what a cut can need.
  std::size_t solid_blocks() const { return solid_blocks_; }
  std::size_t bytes() const {
    return field_.bytes() + material_.size() * sizeof(std::int32_t) + mixed_.size();
  }

 private:
  void TakeMaterials(const SolidGridOptions& options, const std::string& name);

  SparseField field_;
  std::vector<std::int32_t> material_;  ///< of a block: -1 - material, or its place in mixed_
  std::vector<std::uint8_t> mixed_;     ///< 512 a block
  std::size_t solid_blocks_ = 0;
};

/// What a grid may take, and a session's cuts in it again [bytes]: a tooth of 10 mm at 50 um takes
/// a quarter.
inline constexpr std::size_t kMostGridBytes = 256u << 20;

/// Throws Error, which begins with the name, unless the mesh is closed, finite and wound
/// counter-clockwise seen from outside: only then something lies within it.
void CheckEncloses(const TriangleMesh& mesh, const std::string& name);

/// Of a body that has a `grid`, in its frame, with the materials that its regions paint.  A point
/// is of a region that is a mesh where that winds round it, counted as for the grid's own sign; of
/// the region's mesh any part may lie outside of the body.  Throws as SolidGrid does.
std::shared_ptr<const SolidGrid> MakeSolidGrid(const Body& body);

}  // namespace palpate
