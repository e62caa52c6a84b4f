#include "scenes/effects/effects.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "common/error.h"
#include "common/math/random.h"
#include "common/math/rotation.h"

namespace palpate {
namespace {

constexpr double kPeriod_s = 1e-3;
constexpr double kShare = 0.2;  // weight of a new difference in the velocity
// Limits per cycle.  No hand is faster; after a jump of the tool the velocity is zero.
constexpr double kFarthest_m = 5e-3, kHalfTurn = 0.05;

void Copy(const Vec3& from, double to[3]) noexcept {
  std::memcpy(to, from.data(), sizeof(double[3]));
}

void Copy(const Quat& q, double wxyz[4]) noexcept {
  wxyz[0] = q.w();
  std::memcpy(wxyz + 1, q.coeffs().data(), sizeof(double[3]));
}

/// Returns how the effect failed; null: it did not.
const char* Call(const palpate_effect& effect, const palpate_effect_input& input, double* state,
                 palpate_effect_wrench& wrench) noexcept {
  try {
    if (effect.step(&input, state, &wrench) != 0) return "step returned that it failed";
  } catch (...) {
    return "step threw an exception, which it must not";
  }
  // False also for NaN.
  const auto is_fine = [](double number) { return std::abs(number) <= PALPATE_EFFECT_MOST; };
  return std::ranges::all_of(wrench.force_N, is_fine) &&
                 std::ranges::all_of(wrench.torque_Nm, is_fine)
             ? nullptr
             : "step gave a wrench that is not finite, or beyond 10,000 N or N m";
}

bool Fits(const palpate_effect_parameter& parameter, const std::vector<double>& values) {
  const bool fits = parameter.kind == PALPATE_EFFECT_NUMBER ? values.size() == 1
                    : parameter.kind == PALPATE_EFFECT_POINT
                        ? values.size() == 3
                        : values.size() >= 6 && values.size() % 3 == 0;
  return fits && std::ranges::all_of(values, [&](double value) {
           return value >= parameter.least && value <= parameter.most;
         });
}

}  // namespace

void Follow(const Pose& X_WH, EffectState& state) noexcept {
  const Vec3 way = X_WH.p - state.X_WH.p;
  Quat turn = X_WH.q * state.X_WH.q.conjugate();
  if (turn.w() < 0.0) turn.coeffs() = -turn.coeffs();
  state.X_WH = X_WH;
  if (state.cycle == 0 || !(way.squaredNorm() <= kFarthest_m * kFarthest_m) ||
      !(turn.vec().squaredNorm() <= kHalfTurn * kHalfTurn)) {
    state.V_WH = {};
    return;
  }
  // Takes the sine of half the angle for the angle: right to 0.05 % at the fastest.
  state.V_WH.v += kShare * (way / kPeriod_s - state.V_WH.v);
  state.V_WH.w += kShare * (2.0 / kPeriod_s * turn.vec() - state.V_WH.w);
}

std::span<const palpate_effect_parameter> ParametersOf(const palpate_effect& effect) {
  const std::span all(effect.parameters);
  return all.first(static_cast<std::size_t>(
      std::ranges::find(all, nullptr, &palpate_effect_parameter::name) - all.begin()));
}

Effects::Effects(std::vector<Effect> effects) : effects_(std::move(effects)) {
  for (const Effect& effect : effects_) {
    const std::string who = "effect " + effect.file;
    if (effect.of == nullptr) throw Error(who + ": is not loaded; load its scene with LoadScene");
    const auto parameters = ParametersOf(*effect.of);
    if (!std::ranges::equal(parameters, effect.values, Fits)) {
      throw Error(who + ": its parameters do not match the effect; build the scene again");
    }
    auto& values = values_.emplace_back();
    for (const auto& numbers : effect.values) values.push_back({numbers.data(), numbers.size()});
  }
}

bool Effects::Step(const Pose& X_WH, const Pose& X_WG, const Vec3& reference, EffectState& state,
                   EffectWrenches& wrenches) const noexcept {
  if (state.of.size() != effects_.size()) return true;
  Follow(X_WH, state);
  palpate_effect_input input;
  input.cycle = state.cycle++;
  bool fine = true;
  for (std::size_t i = 0; i < effects_.size(); ++i) {
    EffectState::Memory& memory = state.of[i];
    if (memory.failure != nullptr) continue;
    // Filled again for each effect, so that one that writes to its input does not affect the next.
    Copy(X_WH.p, input.position_m);
    Copy(X_WH.q, input.orientation_wxyz);
    Copy(state.V_WH.v, input.velocity_m_s);
    Copy(state.V_WH.w, input.turn_rad_s);
    Copy(X_WG.p, input.graphic_position_m);
    Copy(X_WG.q, input.graphic_orientation_wxyz);
    input.values = values_[i].data();
    palpate_effect_wrench given{};
    memory.failure = Call(*effects_[i].of, input, memory.state.data(), given);
    if (memory.failure != nullptr) {
      fine = false;
      continue;
    }
    Wrench& sum = effects_[i].of->passive != 0 ? wrenches.passive : wrenches.active;
    const Vec3 force(given.force_N);
    sum.force += force;
    sum.torque += Vec3(given.torque_Nm) - (X_WH.q * reference).cross(force);
  }
  return fine;
}

namespace {

/// Returns a smooth random walk that ends where it began, reaches up to `reach` from its centre,
/// and contains all frequencies of a hand.
std::vector<Vec3> ClosedWalk(Random& random, int steps, double reach) {
  std::vector<Vec3> walk{Vec3::Zero()};
  Vec3 velocity = Vec3::Zero();
  for (int i = 0; i < steps; ++i) {
    velocity += 0.05 * (random.Direction() - velocity);
    walk.push_back(walk.back() + velocity);
  }
  const Vec3 drift = walk.back() / steps;
  double farthest = 1e-9;
  for (int i = 0; i <= steps; ++i) farthest = std::max(farthest, (walk[i] -= i * drift).norm());
  for (Vec3& p : walk) p *= reach / farthest;
  return walk;
}

}  // namespace

double EnergyGiven(const Effect& effect, const Vec3& centre, double radius) {
  constexpr int kPaths = 8, kSteps = 8000;
  const Effects effects({effect});
  Random random(1);
  std::vector<Vec3> places, turns;
  double worst = -1.0;
  for (int path = 0; path < 2 * kPaths; ++path) {
    if (path % 2 == 0) {
      places = ClosedWalk(random, kSteps, radius);
      turns = ClosedWalk(random, kSteps, 1.0);
    } else {
      std::ranges::reverse(places);
      std::ranges::reverse(turns);
    }
    EffectState state = effects.Begin();
    Pose before;
    Wrench held;
    double given = 0.0, moved = 0.0;
    for (int i = 0; i <= kSteps; ++i) {
      const Pose X{centre + places[i], RotationExp(turns[i])};
      EffectWrenches now;
      if (!effects.Step(X, X, Vec3::Zero(), state, now)) {
        return std::numeric_limits<double>::infinity();
      }
      const Wrench all{now.passive.force + now.active.force,
                       now.passive.torque + now.active.torque};
      if (i > 0) {
        const double work =
            0.5 * ((all.force + held.force).dot(X.p - before.p) +
                   (all.torque + held.torque).dot(RotationLog(X.q * before.q.conjugate())));
        given += work;
        moved += std::abs(work);
      }
      before = X;
      held = all;
    }
    if (moved > 0.0) worst = std::max(worst, given / moved);
  }
  return worst;
}

}  // namespace palpate
