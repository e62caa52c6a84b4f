#pragma once

#include "devices/limiter/energy_stage.h"
#include "devices/limiter/limiter_chain.h"

namespace palpate {

/// A wrench that a device may render.  Only WrenchLimiter can make one, so no other path to a
/// device compiles.
class LimitedWrench {
 public:
  const Wrench& wrench() const noexcept { return wrench_; }

 private:
  friend class WrenchLimiter;
  friend class WorkspaceDevice;  // only transforms it into the device's own frame and units
  explicit LimitedWrench(const Wrench& wrench) noexcept : wrench_(wrench) {}
  Wrench wrench_;
};

/// The only path to a device: a chain of stages (limiter/): finite, clamp, slew, energy,
/// temperature, age, enable; README.md says what each does and why.  A guide's wrench has a finite,
/// clamp (with a small bound) and slew stage of its own, is added to the contact wrench before
/// temperature, and shares the later stages.  No stage can be left out or switched off.
///
/// For every input, with dt the time that a call counts for (CountedTick): force and torque
/// are finite, at most their limit, and change by at most their slew limit x dt. Proof.  Let c be
/// the contact force after the energy stage.  It changes by at most r dt, the limit of that stage's
/// own slew, and stays within the peak F: its targets are no longer than the slew stage's output,
/// whose targets lie in the ball of radius F, and balls are convex.  The guide's force l changes by
/// at most r_l dt.  Temperature projects c + l on a ball of radius R <= F, which moves no two
/// points further apart; R itself changes by at most r_R dt.  So its result y has |y| <= F and |dy|
/// <= (r + r_l + r_R) dt.  The output is a e y with the factors of age and enable in [0, 1], which
/// change at rates of at most r_a and r_e, and |d(a e y)| <= |dy| + F (r_a + r_e) dt.
/// WrenchLimits::rates() chooses r so that r + r_l + r_R + F (r_a + r_e) is the slew limit.  If the
/// last a e was zero, y may jump within its ball: the output then changes by at most F (r_a + r_e)
/// dt.  The slew limit does not delay the later stages: age alone takes the output to zero by 25 ms
/// of silence.
///
/// Pure: time is an argument, equal inputs give equal bits.
/// Real-time: no allocation, lock, log or clock.  Not thread-safe: the loop's thread owns it.
class WrenchLimiter {
 public:
  explicit WrenchLimiter(const WrenchLimits& limits) : chain_(limits) {}

  /// Returns the wrench to render.  Call it once per tick.
  LimitedWrench Limit(const LimiterInput& in) noexcept { return LimitedWrench(chain_.Limit(in)); }

  void Enable(bool on) noexcept { chain_.Enable(on); }
  bool enabled() const noexcept { return chain_.enabled(); }
  /// Sets the stiffness of the session's spring (EnergyStage::SetStiffness).
  void SetStiffness(double N_per_m) noexcept { chain_.energy().SetStiffness(N_per_m); }

  /// Returns true while the age of replies keeps the wrench below what was requested.
  bool fading() const noexcept { return chain_.fading(); }
  LimiterCounts counts() const noexcept { return chain_.counts(); }
  /// Observer of the energy at the handle [J], which the hand has put into contacts and not
  /// got back.
  const PassivityObserver& observer() const noexcept { return chain_.energy().observer(); }
  /// Modelled temperature of the motors: at 1 only the continuous figures remain.
  double warmth() const noexcept { return chain_.temperature().warmth(); }
  const WrenchLimits& limits() const noexcept { return chain_.limits(); }

 private:
  LimiterChain<EnergyStage> chain_;
};

}  // namespace palpate
