#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/grid/bur.h"
#include "scenes/grid/cut_field.h"
#include "server/physics/cut/cutting.h"
#include "server/physics/energy/energy.h"
#include "server/physics/simd/aligned_columns.h"

namespace palpate {

/// A bur during a haptic step.  All quantities are in W, except the samples, which are in T.
struct CutTool {
  std::span<const BurSample> samples;
  Pose X_WT;
  Vec3 reference = Vec3::Zero();  ///< point about which x turns it [m]
  double stiffness = 0.0;         ///< k_t of the coupling [N/m]
  double rotation_length = 1.0;   ///< rho [m], sqrt(k_r / k_t); infinite: nothing turns it
  double dt = 1e-3;               ///< of the step [s]
};

/// One row for each sample that has material ahead: the energy of cutting in a step
/// x = [v; rho phi] of the tool.  Sample i advances delta_i = max(0, b_i - a_i . x) into the
/// material and pays
///
///    A_i (p_0 delta_i + kappa delta_i^2 / 2 dt)  =  k_t (P_i delta_i + c_i delta_i^2 / 2).
///
/// a_i = -[n_i; (l_i x n_i) / rho] with l_i from the reference to the sample, and b_i = -g_i, the
/// gap (README.md).  A sample that cannot cut has a p_0 that no hand can overcome.  Passive: a row
/// pushes only where -a_i . x >= g_i >= 0, so its work on the material is >= 0 for every x.
/// `yielding` holds a_i, b_i [m], P_i [m] as the threshold and c_i as the weight.
class CutRows : public YieldingEnergy {
 public:
  /// @param samples  most rows: the number of the bur's samples, once more for each further solid
  ///                 that it may touch at once.  Set-up.
  explicit CutRows(int samples);

  void Clear() { yielding.rows.count = 0; }
  /// Adds the rows of what is left of a solid.
  /// @param X_WB  of the solid.   @param materials  indexed by their number in its grid
  /// @param reach  material that lies farther ahead gets no row [m]
  /// Valid for steps no longer than the grid's band.  Real-time.
  void AddSolid(const CutTool& tool, const CutField& cut, const Pose& X_WB,
                std::span<const Material> materials, double reach = 1e300) noexcept;

  bool Collect(const ContactRows&, QpRows&) noexcept override { return count() > 0; }

  /// Whether material pushed at the solver's result.
  bool pushes() const { return count() > 0 && pushing > 0; }

  int count() const { return yielding.rows.count; }
  const double* area() const { return columns_[kArea]; }  ///< A_i [m^2]

  /// Returns the drag on the tool by the bur's spin at the solver's result, - sum of
  /// mu_c f_i [s_i; (l_i x s_i) / rho], with f_i the force of a row and s_i the direction in which
  /// the bur's surface moves; over k_t [m].
  Vec6 Drag() const noexcept;

  /// Adds a single row, for tests and for custom rows; a row beyond the capacity is dropped.
  void Add(const std::array<double, 6>& a, double b, double threshold, double viscous,
           double area) noexcept;

 private:
  enum : std::size_t { kB = 6, kThreshold, kViscous, kArea, kPush, kColumns };
  /// Sets a row; `row` may lie in the padding.
  void Set(std::size_t row, const std::array<double, 6>& a, double b, double threshold,
           double viscous, double area) noexcept;

  int capacity_;
  AlignedColumns columns_;
  struct Slide {
    double friction = 0.0;  ///< mu_c; if 0, the other members are unused
    Vec3 along, turn;       ///< s_i and (l_i x s_i) / rho
  };
  std::vector<Slide> slides_;  ///< for each row
};

}  // namespace palpate
