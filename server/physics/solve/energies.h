#pragma once

#include <array>
#include <optional>
#include <span>

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
  explicit Energies(const HapticModel& model);

  /// Returns the bounds of a sub-step that begins with the tool's reference point at p_G.
  /// They are narrower where the bur may reach a solid, because its rows are valid only
  /// within the grid's band.
  StepBounds Narrow(StepBounds bounds, const Vec3& p_G, const Quat& q_WG) const noexcept;
  /// Begins that sub-step.
  /// @param cuts   what has been removed from each solid; empty if the bur does not cut
  /// @param reach  how far ahead the bur finds material [m]
  void Begin(const Vec3& p_G, const Quat& q_WG, std::span<const CutField> cuts,
             double reach) noexcept;
  /// Call before each solve: collects the energies that act among these rows, and removes the rows
  /// that yield from the rigid ones.
  void Collect(const ContactRows& rows, QpRows& rigid) noexcept;
  bool acts() const { return acting_ > 0; }

  /// Returns the step nearest to t under the rigid rows and the acting energies (EnergySolver).
  QpResult Solve(const Kernels& kernels, const double* t, const QpRows& rigid,
                 std::span<const int> guess) noexcept;
  /// Whether any energy pushed at the result; and the sum of their forces, on [v; rho phi], over
  /// the coupling's stiffness [m].
  bool pushes() const noexcept;
  bool bur_pushes() const noexcept { return cut_ && cut_->count() > 0 && cut_->pushing > 0; }
  Vec6 force() const noexcept;
  /// The drag of the bur's spin at the result (CutRows::Drag).
  Vec6 Drag() const noexcept { return bur_pushes() ? cut_->Drag() : Vec6(Vec6::Zero()); }

  /// Null if no row is soft.
  const SoftRows* soft() const { return soft_ && soft_->any() ? &*soft_ : nullptr; }
  /// Removes what the bur passes through in a motion of the tool from p_G.  Returns CutAway::looks.
  int Cut(const Vec3& p_G, const Quat& q_WG, const Vec3& v, const Vec3& phi,
          std::span<CutField> cuts) noexcept;

 private:
  const HapticModel* model_;
  EnergySolver solver_;
  std::optional<SoftRows> soft_;
  std::optional<CutRows> cut_;
  std::array<Energy*, 2> energies_{};
  std::size_t acting_ = 0;
};

}  // namespace palpate
