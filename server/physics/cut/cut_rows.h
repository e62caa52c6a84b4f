#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/grid/bur.h"
#include "scenes/grid/cut_field.h"

namespace palpate {

/// What it takes to press a bur's edge into a material.
struct CutMaterial {
  double pressure = 0.0;   ///< p_0 > 0 [Pa]: up to it the material is rigid
  double viscosity = 0.0;  ///< kappa >= 0 [Pa s/m]: what each m/s of the edge adds
};

/// A bur in the hand of a haptic step.  All in W but for the samples, which are in T.
struct CutTool {
  std::span<const BurSample> samples;
  Pose X_WT;
  Vec3 reference = Vec3::Zero();  ///< about which x turns it [m]
  double stiffness = 0.0;         ///< k_t of the coupling [N/m]
  double rotation_length = 1.0;   ///< rho [m], sqrt(k_r / k_t)
  double dt = 1e-3;               ///< of the step [s]
};

/// One row for each sample that has material before it.  For the step x = [v; rho phi] of the tool,
/// sample i goes delta_i = max(0, a_i . x - g_i) into it, at the price
///
///     A_i (p_0 delta_i + kappa delta_i^2 / 2 dt)  =  k_t (P_i delta_i + c_i delta_i^2 / 2),
///
/// a_i = [n_i; (l_i x n_i) / rho] with l_i from the reference to the sample.  The gap g_i >= 0 is
/// how far the material lies ahead along n_i; below 0 it is taken for 0, for what a bur cleared it
/// cleared, though the grid says some micrometre less.
class CutRows {
 public:
  /// @param samples  of the largest bur.  Set-up.
  explicit CutRows(int samples);

  /// @param X_WB  of the solid.   @param materials  by their number in the solid's grid; all of
  /// them.   Right for steps of no more than the grid's band.  Real-time.
  void Build(const CutTool& tool, const CutField& cut, const Pose& X_WB,
             const std::array<CutMaterial, SolidGrid::kMaterials>& materials) noexcept;

  int count() const { return count_; }
  const double* a(int unknown) const { return Column(unknown); }
  const double* gap() const { return Column(kGap); }
  const double* threshold() const { return Column(kThreshold); }  ///< P_i [m]
  const double* viscous() const { return Column(kViscous); }      ///< c_i
  const double* area() const { return Column(kArea); }            ///< A_i [m^2]

  /// A row by itself, for tests and for rigid or other rows of one's own.
  void Clear() { count_ = 0; }
  void Add(const std::array<double, 6>& a, double gap, double threshold, double viscous,
           double area) noexcept;

 private:
  enum : int { kGap = 6, kThreshold, kViscous, kArea, kColumns };
  const double* Column(int c) const {
    return storage_.data() + static_cast<std::size_t>(c) * static_cast<std::size_t>(capacity_);
  }

  int capacity_, count_ = 0;
  std::vector<double> storage_;
};

}  // namespace palpate
