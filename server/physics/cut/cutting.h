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

/// What it takes to press a bur's edge into a material.
struct CutMaterial {
  double pressure = 0.0;   ///< p_0 > 0 [Pa]: up to it the material is rigid
  double viscosity = 0.0;  ///< kappa >= 0 [Pa s/m]: what each m/s of the edge adds
  double friction = 0.0;   ///< mu_c >= 0: the force along a spinning surface over that against it
};

/// A solid that a bur can cut.
struct CutSolid {
  std::shared_ptr<const SolidGrid> grid;
  Pose X_WB;
  std::array<CutMaterial, SolidGrid::kMaterials> materials;  ///< by their number in the grid
  std::uint32_t object = 0;                                  ///< its place among the scene's
};

/// A bur in a tool, or an edge.  What else of the tool's tree and mesh meets is rigid.
struct Cutting {
  Bur bur;
  Pose X_TB;             ///< of the bur's frame, in the tool's
  int samples = 384;     ///< of the bur's surface
  double period = 1e-3;  ///< between two poses [s]: what viscosity is told of a step's speed
  BurSpin spin{};
  double dead_tip = 0.0, cutting = 0.0;  ///< what of it cuts (BurProfile) [m]
  std::optional<Vec3> sense{};           ///< of an edge: unit, in T; none: a bur
};

}  // namespace palpate
