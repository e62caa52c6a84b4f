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
  /// The most memory that the grid may take [bytes].
  std::size_t most_bytes = 64u << 20;
  /// Returns the material of a point of B, below SolidGrid::kMaterials; null: all of it
  /// is material 0.
  std::function<std::uint8_t(const Vec3& p_B)> material = nullptr;
};

/// A solid that can be cut: the signed distance to its mesh, in a band of 3 h round the surface, at
/// the points of a lattice, and the material of each solid point.  Immutable, so threads may share
/// it; what burs have removed is in a CutField beside it.
class SolidGrid {
 public:
  /// Half-width of the band over the spacing.  A point whose cell the surface crosses lies within
  /// sqrt(3) h of it, and its neighbours, which the gradient of the volume needs, within another h.
  static constexpr int kBandSpacings = 3;
  static constexpr int kMaterials = 8;

  /// Distances are those to the nearest triangle (exact except for rounding to float).  The sign
  /// comes from the winding number, counted along a line through the lattice, so it is right beside
  /// edges and corners and for every shell.  Surface inside the solid (shells that overlap) counts
  /// as surface: the distance is small beside it.  Deterministic.  Set-up: allocates, and takes
  /// some tenths of a second for a tooth.
  /// `mesh`: closed, oriented, in frame B [m]; `name`: of the body, for error messages.
  /// Throws Error, before the grid allocates, if the mesh is open, empty or inside out, or if the
  /// grid would take more memory than it may.
  /// or the grid would take more than it may.
  SolidGrid(const TriangleMesh& mesh, const SolidGridOptions& options, const std::string& name);

  const SparseField& field() const { return field_; }
  /// Real-time.
  FieldSample Sample(const Vec3& p_B) const noexcept { return field_.Sample(p_B); }
  /// Returns the material of the lattice point nearest to p; 0 outside the lattice.  Real-time.
  std::uint8_t Material(const Vec3& p_B) const noexcept;
  std::uint8_t MaterialOf(std::size_t block, int point) const {
    const std::int32_t entry = material_[block];
    return entry < 0 ? static_cast<std::uint8_t>(-1 - entry)
                     : mixed_[static_cast<std::size_t>(entry) * SparseField::kPoints +
                              static_cast<std::size_t>(point)];
  }
  /// Returns the number of blocks that are not free throughout: the most that cuts can need.
  std::size_t solid_blocks() const { return solid_blocks_; }
  std::size_t bytes() const {
    return field_.bytes() + material_.size() * sizeof(std::int32_t) + mixed_.size();
  }

 private:
  void TakeMaterials(const SolidGridOptions& options, const std::string& name);

  SparseField field_;
  std::vector<std::int32_t> material_;  ///< for each block: -1 - material, or its index in mixed_
  std::vector<std::uint8_t> mixed_;     ///< 512 per block
  std::size_t solid_blocks_ = 0;
};

/// The most memory that a grid may take, and again a session's cuts in it [bytes].  A tooth of 10
/// mm at 50 um takes a quarter of that.
inline constexpr std::size_t kMostGridBytes = 256u << 20;

/// Throws Error, which begins with the name, unless the mesh is closed, finite and wound
/// counter-clockwise seen from outside: only then does it enclose something.
void CheckEncloses(const TriangleMesh& mesh, const std::string& name);

/// Makes the grid of a body that has one (Body::grid), in the body's frame, with the materials of
/// its regions.  A point belongs to a region that is a mesh if that winds round it, counted as for
/// the grid's sign; the region's mesh may reach out of the body.  Throws as SolidGrid does.
std::shared_ptr<const SolidGrid> MakeSolidGrid(const Body& body);

}  // namespace palpate
