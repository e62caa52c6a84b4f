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

/// A bur in the hand of a haptic step.  All in W but for the samples, which are in T.
struct CutTool {
  std::span<const BurSample> samples;
  Pose X_WT;
  Vec3 reference = Vec3::Zero();  ///< about which x turns it [m]
  double stiffness = 0.0;         ///< k_t of the coupling [N/m]
  double rotation_length = 1.0;   ///< rho [m], sqrt(k_r / k_t)
  double dt = 1e-3;               ///< of the step [s]
  bool spins = true;              ///< else all of it is rigid
};

/// One row for each sample that has material before it: the energy of a step x = [v; rho phi] of
/// the tool.  Sample i goes delta_i = max(0, b_i - a_i . x) into it, at the price
///
///     A_i (p_0 delta_i + kappa delta_i^2 / 2 dt)  =  k_t (P_i delta_i + c_i delta_i^2 / 2).
///
/// a_i = -[n_i; (l_i x n_i) / rho] with l_i from the reference to the sample, and b_i = -g_i.  The
/// gap g_i >= 0 is how far the material lies ahead along n_i; below 0 it is taken for 0, for what a
/// bur cleared it cleared, though the grid says some micrometre less.  What does not cut pays a
/// p_0 that no hand has; of a bur that stands still, along the solid's normal.
///
/// Passive: a row pushes only where -a_i . x >= g_i >= 0, so that its work on the material is >= 0,
/// whatever x is.
class CutRows : public Energy {
 public:
  /// @param samples  rows at most: the bur's samples, and those once more for each solid more that
  ///                 it may touch at once.  Set-up.
  explicit CutRows(int samples)
      : capacity_(samples),
        columns_(kColumns, static_cast<std::size_t>(samples)),
        slides_(static_cast<std::size_t>(samples)) {}

  void Clear() { count_ = 0; }
  /// Adds the rows of what is left of a solid.
  /// @param X_WB  of the solid.   @param materials  by their number in its grid; all of them.
  /// @param reach  material that lies farther ahead has no row [m].
  /// Right for steps of no more than the grid's band.  Real-time.
  void AddSolid(const CutTool& tool, const CutField& cut, const Pose& X_WB,
                const std::array<CutMaterial, SolidGrid::kMaterials>& materials,
                double reach = 1e300) noexcept;

  int count() const { return count_; }
  const double* a(std::size_t unknown) const { return columns_[unknown]; }
  const double* b() const { return columns_[kB]; }                  ///< [m]
  const double* threshold() const { return columns_[kThreshold]; }  ///< P_i [m]
  const double* viscous() const { return columns_[kViscous]; }      ///< c_i
  const double* area() const { return columns_[kArea]; }            ///< A_i [m^2]
  /// Whether any of them pushes at the solver's result.
  bool pushes() const { return pushing_ > 0; }
  /// Force of each row there, over k_t [m].
  const double* forces() const { return columns_[kPush]; }

  /// Of the spin there: what the material drags the tool by, - sum of mu_c f_i [s_i; (l_i x s_i) /
  /// rho], with f_i a row's force and s_i where the bur's surface goes; over k_t [m].
  std::array<double, 6> Drag() const noexcept;

  /// What the rows say of a step x: sum of A_i delta_i [m^3].
  double VolumeOf(const double* x, int unknowns) const noexcept;
  /// Work that the solver's forces do on the material in a step x, over k_t [m^2].
  double WorkOf(const double* x, int unknowns) const noexcept;

  /// A row by itself, for tests and for rows of one's own; what does not fit is left out.
  void Add(const std::array<double, 6>& a, double b, double threshold, double viscous,
           double area) noexcept;

  void Add(const Kernels& kernels, const double* x, int unknowns, const Springs& springs,
           EnergyAt& at) noexcept override;
  void AddHessian(const Kernels& kernels, const double* x, int unknowns, const Springs& springs,
                  EnergyAt& at) const noexcept override;
  bool HasThresholds() const noexcept override { return true; }

 private:
  enum : std::size_t { kB = 6, kThreshold, kViscous, kArea, kPush, kColumns };
  /// Of a point at p_W of a bur that stands still, and what the solid is there.
  void AddRigid(const CutTool& tool, const FieldSample& here, double reach, const Vec3& p_W,
                const Mat3& R_WB, double area) noexcept;
  /// To the end of the padding.
  void Set(std::size_t row, const std::array<double, 6>& a, double b, double threshold,
           double viscous, double area) noexcept;
  YieldingRows Yielding() const noexcept;

  int capacity_, count_ = 0, pushing_ = 0;
  AlignedColumns columns_;
  struct Slide {
    double friction = 0.0;  ///< mu_c; 0: the others do not count
    Vec3 along, turn;       ///< s_i and (l_i x s_i) / rho
  };
  std::vector<Slide> slides_;  ///< of each row
};

}  // namespace palpate
