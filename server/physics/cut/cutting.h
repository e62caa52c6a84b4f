#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/math/pose.h"
#include "scenes/grid/bur.h"
#include "scenes/grid/solid_grid.h"
#include "scenes/scene.h"

namespace palpate {

/// A solid that a bur can cut.
struct CutSolid {
  std::shared_ptr<const SolidGrid> grid;
  Pose X_WB;
  std::array<Material, SolidGrid::kMaterials> materials;  ///< indexed by their number in the grid
  std::uint32_t object = 0;                               ///< index of its object in the scene
};

/// The bur, or the edge, of a tool.  Whatever else the tool's tree and mesh meet is rigid to them.
struct Cutting {
  Bur bur;
  Pose X_TB;             ///< pose of the bur's frame in the tool's
  int samples = 384;     ///< of the bur's surface
  double period = 1e-3;  ///< time between two poses [s], which viscosity takes
                         ///< for a step's duration
  BurSpin spin{};
  double dead_tip = 0.0, cutting = 0.0;  ///< which part of it cuts (BurProfile) [m]
  std::optional<Vec3> sense{};  ///< cutting direction of an edge: unit, in T; empty for a bur
};

}  // namespace palpate
