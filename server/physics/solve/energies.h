#pragma once

#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/grid/cut_field.h"
#include "server/physics/cut/cut_rows.h"
#include "server/physics/energy/energy_solver.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/rows/soft_rows.h"
#include "server/physics/step_types.h"

namespace palpate {

/// The energies of a model beside the coupling's: the only place that knows which kinds exist.
/// Real-time except for the constructor.
class Energies {
 public:
  /// Enters every kind that can act in the model.
  explicit Energies(const HapticModel& model);
  /// Whether none can act.
  bool empty() const { return all_.empty(); }

  /// How far a bur's points may go in a sub-step near a solid: half of its grid's band, for farther
  /// gaps are not known; infinite without a bur [m].
  double bur_step() const { return bur_step_; }
  /// Returns the greatest fraction of a step from p_G, at most 1, in which they go no farther.
  double FractionWithin(const Vec3& p_G, const Quat& q_WG, const Vec3& v,
                        const Vec3& phi) const noexcept;
  /// Begins that sub-step.
  void Begin(const EnergyStart& start) noexcept;
  /// Call before each solve: collects the energies that act among these rows, and removes the rows
  /// that yield from the rigid ones.
  void Collect(const ContactRows& rows, QpRows& rigid) noexcept;
  bool acts() const { return !acting_.empty(); }

  /// Returns the step nearest to t under the rigid rows and the acting energies (EnergySolver).
  QpResult Solve(const Kernels& kernels, const double* t, const QpRows& rigid,
                 std::span<const int> guess) noexcept;
  /// Whether any energy pushed at the result; and the sum of their forces, on [v; rho phi], over
  /// the coupling's stiffness [m].
  bool pushes() const noexcept;
  Vec6 force() const noexcept;

  /// Null if no row is soft.
  const SoftRows* soft() const { return soft_ != nullptr && soft_->any() ? soft_ : nullptr; }
  /// Null if no material pushes a bur.
  const CutRows* bur() const { return bur_ != nullptr && bur_->pushes() ? bur_ : nullptr; }
  /// Removes what the bur passes through in a motion of the tool from p_G.  Returns
  /// CutAway::queries.
  int Cut(const Vec3& p_G, const Quat& q_WG, const Vec3& v, const Vec3& phi,
          std::span<CutField> cuts) noexcept;

 private:
  const HapticModel* model_;
  EnergySolver solver_;
  std::vector<std::unique_ptr<Energy>> all_;
  std::vector<Energy*> acting_;
  double bur_step_ = std::numeric_limits<double>::infinity();
  // Those of `all_` that the report and the solids know; null if there are none.
  SoftRows* soft_ = nullptr;
  CutRows* bur_ = nullptr;
};

}  // namespace palpate
