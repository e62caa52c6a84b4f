#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/math/pose.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/step_types.h"
#include "server/physics/surface/body_surfaces.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

/// Rows between the true surfaces of tool and objects for one sub-step.  One per workspace.
class SurfacePrediction {
 public:
  SurfacePrediction(const ToolSurface& tool, const ObjectSurfaces& objects);

  /// Adds the rows for the graphic tool at R_WG with its reference point at p_W.
  /// Where `times` is given, adds to its prediction and rows stages.  Real-time.
  /// @param max_depth  what lies deeper below a surface than this is no concern of it [m];
  ///   infinite: also what lies inside and could not have come there
  /// @param recovery  what a row wants made good in full of what lies below [m]; of the rest a
  /// part.
  ///   A spherical tool's rows want all
  void Predict(const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W, const StepBounds& bounds,
               double max_depth, double recovery, int degrees_of_freedom, double rho,
               ContactRows& rows, StageTimes* times) noexcept;

  /// Packet pairs tested so far, and pairs looked at for a row: either takes some 10 ns.
  std::int64_t tested() const;

 private:
  const ToolSurface& tool_;
  const ObjectSurfaces& objects_;
  std::vector<NodePair> near_;
  std::int64_t candidates_ = 0;
  std::optional<PairQuery> point_on_patch_, patch_on_point_, creases_;
};

}  // namespace palpate
