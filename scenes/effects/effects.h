#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/effects/palpate_effect.h"

namespace palpate {

/// A force of one's own in a scene (palpate_effect.h).
struct Effect {
  std::string file;                         ///< of its shared object, without the folder
  std::uint64_t hash = 0;                   ///< of that file's bytes
  std::vector<std::vector<double>> values;  ///< of each parameter
  /// What the file defines; null where it is not loaded, for who only draws a scene.
  const palpate_effect* of = nullptr;
};

/// Those that have a name.
std::span<const palpate_effect_parameter> ParametersOf(const palpate_effect& effect);

/// What effects remember from step to step.
struct EffectState {
  struct Memory {
    std::array<double, PALPATE_EFFECT_STATES> state{};
    bool is_off = false;  ///< it has failed
  };
  std::vector<Memory> of;  ///< each effect; none: none act
  std::uint64_t cycle = 0;
  Pose X_WH;
  Twist V_WH;
};

/// The hand is there in this cycle: what it moves by, smoothed.  Real-time.
void Follow(const Pose& X_WH, EffectState& state) noexcept;

/// On the hand, at the tool's reference point, in W.
struct EffectWrenches {
  Wrench passive, active;
};

/// The effects of a scene, as they act.  Immutable; shared by threads.
class Effects {
 public:
  Effects() = default;
  /// Throws Error where one is not loaded, or its values are not those that it asks for.
  explicit Effects(std::vector<Effect> effects);
  Effects(Effects&&) = default;  // values_ stay where they are
  Effects& operator=(Effects&&) = default;

  bool empty() const { return effects_.empty(); }
  EffectState Begin() const {
    return {std::vector<EffectState::Memory>(effects_.size()), 0, {}, {}};
  }
  /// The next cycle: adds up their wrenches.  False where one failed in it.
  /// `reference`: where the wrenches are to act, in the tool's frame [m].
  /// Real-time, as far as the effects are.
  bool Step(const Pose& X_WH, const Pose& X_WG, const Vec3& reference, EffectState& state,
            EffectWrenches& wrenches) const noexcept;

 private:
  std::vector<Effect> effects_;
  std::vector<std::vector<palpate_effect_values>> values_;  // what effects_ hold
};

/// What an effect gives a hand along closed paths, as a share of all that goes to and fro: of
/// the worst of some that are smooth and random, each gone both ways.
/// `centre`, `radius`: where they lead [m].
double EnergyGiven(const Effect& effect, const Vec3& centre, double radius);
/// Up to here it is the error of the sum, and not energy.
inline constexpr double kNoEnergy = 1e-3;

}  // namespace palpate
