#pragma once

#include "devices/limiter/energy_stage.h"
#include "devices/limiter/limiter_chain.h"

namespace palpate {

/// A wrench that a device may render: only WrenchLimiter makes one, so no other path to a device
/// compiles.
class LimitedWrench {
 public:
  const Wrench& wrench() const noexcept { return wrench_; }

 private:
  friend class WrenchLimiter;
  friend class WorkspaceDevice;  // which only turns one into the device's own frame and units
  explicit LimitedWrench(const Wrench& wrench) noexcept : wrench_(wrench) {}
  Wrench wrench_;
};

/// The one way to a device, an ordered chain of stages (limiter/): finite, clamp, slew, energy,
/// temperature, age, enable; README.md says what each does and why.  What a guide adds passes
/// finite, clamp (its own, small) and slew apart from the contact, joins it before temperature, and
/// shares the rest.  None can be left out or switched off.
///
/// For every input whatever, and with dt the time of a call as it counts (at most kMaxTick_s):
/// force and torque are finite, at most their limit, and change by at most their slew limit x dt.
/// Proof.  Let c be the contact after the energy stage: it moves by at most r dt, as that stage's
/// own slew lets it, and stays within the peak F, for its targets are shorter than what the slew
/// stage gives, that stage's targets are in the ball of radius F, and balls are convex.  The
/// guide's l moves by at most r_l dt.  Temperature projects c + l on a ball of radius R <= F, which
/// moves two points no further apart; R itself moves by at most r_R dt.  So y, what it gives, has
/// |y| <= F and |dy| <= (r + r_l + r_R) dt.  The output is a e y with factors in [0, 1], of rates
/// r_a and r_e, and |d(a e y)| <= |dy| + F (r_a + r_e) dt.  WrenchLimits::rates() chooses r so that
/// r + r_l + r_R + F (r_a + r_e) is the slew limit.  Where the last a e
/// was zero y may leap, within its ball: the output then changes by F (r_a + r_e) dt at most.  No
/// later stage is held up by it: age alone takes the output to zero by 25 ms of silence.
///
/// Pure: time comes in as arguments, equal inputs give equal bits.
/// Real-time: no allocation, lock, log or clock.  Not thread-safe: the loop's thread owns it.
class WrenchLimiter {
 public:
  explicit WrenchLimiter(const WrenchLimits& limits) : chain_(limits) {}

  /// Once per tick.
  LimitedWrench Limit(const LimiterInput& in) noexcept { return LimitedWrench(chain_.Limit(in)); }

  void Enable(bool on) noexcept { chain_.Enable(on); }
  bool enabled() const noexcept { return chain_.enabled(); }
  /// EnergyStage::SetStiffness: the session's spring.
  void SetStiffness(double N_per_m) noexcept { chain_.energy().SetStiffness(N_per_m); }

  /// True while old replies hold the wrench below what was asked for.
  bool fading() const noexcept { return chain_.fading(); }
  LimiterCounts counts() const noexcept { return chain_.counts(); }
  /// Energy at the handle [J]: what the hand has put into contacts and not got back.
  const PassivityObserver& observer() const noexcept { return chain_.energy().observer(); }
  /// Model of the motors' temperature: 1 is where only the continuous figures are left.
  double warmth() const noexcept { return chain_.temperature().warmth(); }
  const WrenchLimits& limits() const noexcept { return chain_.limits(); }

 private:
  LimiterChain<EnergyStage> chain_;
};

}  // namespace palpate
