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

/// The energies beside the coupling's that a model has: the one place that knows which there are.
/// Real-time but for the constructor.
class Energies {
 public:
  explicit Energies(const HapticModel& model);

  /// Bounds of a sub-step that begins with the tool's reference point at p_G: where its bur may
  /// come to a solid they are narrower, for its rows are right within the grid's band.
  StepBounds Narrow(StepBounds bounds, const Vec3& p_G, const Quat& q_WG) const noexcept;
  /// That sub-step begins.
  /// @param cuts   what is gone of each solid; none where the bur stands still: it cuts nothing.
  /// @param reach  how far ahead a bur knows of material [m].
  void Begin(const Vec3& p_G, const Quat& q_WG, std::span<const CutField> cuts,
             double reach) noexcept;
  /// To be called before each solve: collects those that act among these rows, and takes what
  /// yields out of those that no step may violate.
  void Collect(const ContactRows& rows, QpRows& rigid) noexcept;
  bool acts() const { return acting_ > 0; }

  /// The step nearest to t under rigid rows and the energies that act (EnergySolver).
  QpResult Solve(const Kernels& kernels, const double* t, const QpRows& rigid,
                 std::span<const int> guess) noexcept;
  /// Whether any pushed there; what all did, of [v; rho phi], over the coupling's stiffness [m].
  bool pushes() const noexcept;
  bool bur_pushes() const noexcept { return cut_ && cut_->count() > 0 && cut_->pushes(); }
  const double* force() const { return solver_.force(); }
  /// What the bur's spin does there (CutRows::Drag).
  std::array<double, 6> Drag() const noexcept {
    return bur_pushes() ? cut_->Drag() : std::array<double, 6>{};
  }

  /// Null where no row is soft.
  const SoftRows* soft() const { return soft_ && soft_->any() ? &*soft_ : nullptr; }
  /// Takes away what the bur passes in a motion of the tool from p_G.  Returns CutAway::looks.
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
