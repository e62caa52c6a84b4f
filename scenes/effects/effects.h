#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/effects/palpate_effect.h"

namespace palpate {

/// An effect of a scene: a force that a shared object adds (palpate_effect.h).
struct Effect {
  std::string file;                         ///< name of the shared object, without folder
  std::uint64_t hash = 0;                   ///< hash of that file's bytes
  std::vector<std::vector<double>> values;  ///< numbers of each parameter
  /// The definition in that file; null if it is not loaded, for programs that only draw a scene.
  const palpate_effect* of = nullptr;
};

/// Returns the effect's parameters that have a name.
std::span<const palpate_effect_parameter> ParametersOf(const palpate_effect& effect);

/// The state that effects keep from step to step.
struct EffectState {
  struct Memory {
    std::array<double, PALPATE_EFFECT_STATES> state{};
    const char* failure = nullptr;  ///< how it has failed, which turned it off
  };
  std::vector<Memory> of;  ///< one per effect; empty: no effect acts
  std::uint64_t cycle = 0;
  Pose X_WH;
  Twist V_WH;
};

/// Advances the hand to its pose in this cycle, and updates its smoothed velocity.  Real-time.
void Follow(const Pose& X_WH, EffectState& state) noexcept;

/// Wrenches on the hand, at the tool's reference point, in W.
struct EffectWrenches {
  Wrench passive, active;
};

/// The effects of a scene, ready to act.  Immutable; may be shared by threads.
class Effects {
 public:
  Effects() = default;
  /// Throws Error if an effect is not loaded, or its values do not fit its parameters.
  explicit Effects(std::vector<Effect> effects);
  Effects(Effects&&) = default;  // values_ keep their addresses
  Effects& operator=(Effects&&) = default;

  bool empty() const { return effects_.empty(); }
  EffectState Begin() const {
    return {std::vector<EffectState::Memory>(effects_.size()), 0, {}, {}};
  }
  /// Computes the next cycle, and adds the effects' wrenches to `wrenches`.  Returns false if an
  /// effect failed in it.
  /// `reference`: the point at which the wrenches act, in the tool's frame [m].
  /// Real-time, if the effects are.
  bool Step(const Pose& X_WH, const Pose& X_WG, const Vec3& reference, EffectState& state,
            EffectWrenches& wrenches) const noexcept;

 private:
  std::vector<Effect> effects_;
  std::vector<std::vector<palpate_effect_values>> values_;  // of the numbers in effects_
};

/// Returns the energy that an effect gives to a hand along closed paths, as a share of all energy
/// exchanged: the largest of several smooth random paths, each travelled in both directions;
/// infinite if the effect fails.
/// `centre`, `radius`: the ball that contains the paths [m].
double EnergyGiven(const Effect& effect, const Vec3& centre, double radius);
/// Up to this share it is the error of the sum, not energy.
inline constexpr double kNoEnergy = 1e-3;

}  // namespace palpate
