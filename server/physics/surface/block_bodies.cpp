#include "server/physics/surface/block_bodies.h"

#include <optional>

#include <Eigen/Geometry>

#include "server/physics/limits.h"

namespace palpate {
namespace {

using limits::mesh::kMostOfBlock;
using Box = HullTree::Box;

constexpr int kAcross = SparseField::kSide;
/// Vertices of a block lie up to kBefore before its first point and up to kBeyond beyond its last,
/// and within kFromSolid of a solid point of its own or of the next blocks (solid_surface.cpp),
/// except for rounding [h].
constexpr double kBefore = 2.0, kBeyond = 2.0, kFromSolid = 2.0, kRounded = 1e-6;

/// Returns a box for every surface that a block can ever have, around its solid points, because
/// the solid only shrinks.
std::optional<Box> BoxOf(const SparseField& field, std::size_t block) {
  const Lattice& lattice = field.lattice();
  const std::array<int, 3> at = lattice.BlockAt(block);
  const Vec3 first = kAcross * Vec3(at[0], at[1], at[2]);
  constexpr int kPoints = kAcross + 1;
  Eigen::AlignedBox3d solid;
  if (field.entry(block) == SparseField::kBelow) {
    solid = {Vec3(0.0, 0.0, 0.0), Vec3(kAcross, kAcross, kAcross)};
  } else {
    for (int n = 0; n < kPoints * kPoints * kPoints; ++n) {
      const int x = n % kPoints, y = n / kPoints % kPoints, z = n / (kPoints * kPoints);
      if (field.At(kAcross * at[0] + x, kAcross * at[1] + y, kAcross * at[2] + z) < 0.0f) {
        solid.extend(Vec3(x, y, z));
      }
    }
  }
  if (solid.isEmpty()) return std::nullopt;
  const Vec3 low = (solid.min().array() - kFromSolid).cwiseMax(-kBefore) - kRounded;
  const Vec3 high = (solid.max().array() + kFromSolid).cwiseMin(kAcross - 1 + kBeyond) + kRounded;
  const Vec3 origin = lattice.Point(0, 0, 0);
  return Box{origin + lattice.spacing * (first + low), origin + lattice.spacing * (first + high),
             static_cast<std::uint32_t>(block)};
}

}  // namespace

ContactBody BlocksOf(const CutSolid& solid) {
  const SparseField& field = solid.grid->field();
  std::vector<HullTree::Box> boxes;
  for (std::size_t block = 0; block < field.lattice().block_count(); ++block) {
    if (field.entry(block) == SparseField::kAbove) continue;
    if (const auto box = BoxOf(field, block)) boxes.push_back(*box);
  }
  return {std::make_shared<const ContactShape>(ContactMesh(), HullTree(boxes)),
          PlacementOf(solid.X_WB)};
}

void BlockBody::Scratch::Reserve() {
  mesh.Reserve(kMostOfBlock);
  tree.Reserve(kMostOfBlock);
  constexpr std::size_t kMostAndRim = 4 * 3 * (kAcross + 3) * (kAcross + 3) * (kAcross + 3);
  ReserveEach(kMostAndRim, surface.vertices, surface.numbers, surface.triangles, surface.materials);
}

void BlockBody::Reserve() {
  shape.mesh.Reserve(kMostOfBlock);
  shape.tree.Reserve(kMostOfBlock);
  materials.reserve(kMostOfBlock);
}

void BlockBody::Assign(const Of& block, std::size_t own, Scratch& scratch) {
  const SolidSurface& surface = scratch.surface;
  of = block;
  shape.mesh.Assign(surface.vertices, surface.triangles, scratch.mesh);
  shape.tree.Assign(shape.mesh, own, scratch.tree);
  materials.assign(surface.materials.begin(),
                   surface.materials.begin() + static_cast<std::ptrdiff_t>(own));
}

UncutBodies::UncutBodies(std::span<const CutSolid> of, std::span<const ContactBody> boxes_of,
                         std::size_t first)
    : solids(of), boxes(boxes_of), first_body(static_cast<std::int32_t>(first)) {
  BlockBody::Scratch scratch;
  BlockBody made;
  for (std::size_t s = 0; s < solids.size(); ++s) {
    const SolidGrid& grid = *solids[s].grid;
    const SparseField nothing(grid.field().lattice(), grid.field().band(), SparseField::kBelow);
    const HullTree& tree = boxes[s].shape->tree;
    place.emplace_back(grid.field().lattice().block_count(), -1);
    for (HullTree::Node node = 0; node < tree.inner_count(); ++node) {
      const std::int32_t block = tree.BlockOf(node);
      if (block < 0) continue;
      const auto b = static_cast<std::size_t>(block);
      const std::size_t own = TakeSurfaceAndRim({grid, nothing}, b, scratch.surface);
      if (own == 0) continue;
      made.Assign({first_body + static_cast<std::int32_t>(s), node, block}, own, scratch);
      place[s][b] = static_cast<std::int32_t>(bodies.size());
      bodies.push_back(made);  // a copy has no spare capacity
    }
  }
}

}  // namespace palpate
