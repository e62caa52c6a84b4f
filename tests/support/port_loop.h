#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "devices/wrench_limiter.h"
#include "tests/support/random.h"

namespace palpate::test {

constexpr double kMostLateTick_s = 5e-3;

/// A hand on an arm at a virtual wall, over a delayed and lossy link, simulated in virtual time.
struct PortLoopCase {
  int delay_ms = 0;   ///< from a pose to the force for it; 0: in the same tick
  double loss = 0.0;  ///< share of the answers that are lost
  /// In the first half: share of the ticks that the machine delays, by up to kMostLateTick_s; the
  /// ticks that became due meanwhile follow at once.
  double late = 0.0;
  double stiffness_N_per_m = 1000.0;
  double resolution_m = 20e-6;  ///< of the encoders
  double seconds = 10.0;
  unsigned seed = 1;
  /// Target height of the hand's spring above the wall [m]: deep -+ stroke, at this rate.
  double deep_m = -0.008;
  double stroke_m = 0.012;
  double rate_Hz = 1.0;
};

struct PortLoopFigures {
  // The sum of wrench times displacement per tick: positive is energy given to the hand.
  double generated_J = 0.0;       ///< at the end, by the encoders
  double most_generated_J = 0.0;  ///< its greatest value
  double absorbed_J = 0.0;        ///< the sum over the ticks in which the hand gave energy
  double most_change_N = 0.0;     ///< applied minus wanted force, in contact, after the ramp
  double rms_change_N = 0.0;
  double rms_wanted_N = 0.0;
  double fastest_m_s = 0.0;  ///< of the handle
  double deepest_m = 0.0;
};

inline const Wrench& Plain(const Wrench& wrench) {
  return wrench;
}
inline const Wrench& Plain(const LimitedWrench& wrench) {
  return wrench.wrench();
}

/// @param limiter  a WrenchLimiter or an UncontrolledLimiter, which is enabled here.
template <class Limiter>
PortLoopFigures RunPortLoop(Limiter& limiter, const PortLoopCase& c) {
  // The values of HandImpedance and PhantomPremium30; one dimension, normal to the wall.
  constexpr double kMass = 0.713, kSpring = 135.0, kDamper = 6.55, kFriction = 0.2;
  constexpr double kTick = 1e-3;
  constexpr double kSubstep = kTick / 8, kLeastTick = 30e-6;
  Random random(c.seed);
  limiter.Enable(true);
  const auto encode = [&](double z) {
    return c.resolution_m > 0.0 ? std::round(z / c.resolution_m) * c.resolution_m : z;
  };
  const auto target = [&](double t) {
    return c.deep_m + c.stroke_m * std::cos(2.0 * M_PI * c.rate_Hz * t);
  };
  struct Answer {
    double due, sampled;
    double force;
  };
  std::vector<Answer> under_way;  // oldest first
  Answer newest{-1.0, -1.0, 0.0};
  double now = 0.0, dt = kTick;
  double z = target(0.0), v = 0.0, speed = 0.0, last_read = encode(z);
  double held = 0.0;
  double squares = 0.0, wanted_squares = 0.0;
  std::int64_t contact_ticks = 0;
  PortLoopFigures figures;
  const auto ticks = static_cast<std::int64_t>(1e3 * c.seconds);
  for (std::int64_t tick = 0; tick < ticks; ++tick) {
    const double read = encode(z);
    speed += 0.386 * ((read - last_read) / dt - speed);  // a driver's low-pass of 100 Hz
    figures.generated_J += held * (read - last_read);
    figures.absorbed_J += std::max(0.0, -held * (read - last_read));
    figures.most_generated_J = std::max(figures.most_generated_J, figures.generated_J);
    last_read = read;

    const double force = read < 0.0 ? -c.stiffness_N_per_m * read : 0.0;
    if (!(random.Uniform(0.0, 1.0) < c.loss)) {
      under_way.push_back({now + 1e-3 * c.delay_ms, now, force});
    }
    while (!under_way.empty() && under_way.front().due <= now + 1e-9) {
      newest = under_way.front();
      under_way.erase(under_way.begin());
    }
    LimiterInput in;
    in.wanted.force.z() = newest.force;
    in.X_WH.p.z() = read;
    in.V_WH.v.z() = speed;
    if (newest.due >= 0.0) {
      in.silence_s = std::max(0.0, now - newest.due);
      in.age_s = now - newest.sampled;
    }
    in.dt_s = dt;
    held = Plain(limiter.Limit(in)).force.z();

    if (tick > 500 && newest.force > 0.0) {
      const double change = std::abs(held - newest.force);
      figures.most_change_N = std::max(figures.most_change_N, change);
      squares += change * change;
      wanted_squares += newest.force * newest.force;
      ++contact_ticks;
    }
    double next = kTick * static_cast<double>(tick + 1);
    if (c.late > 0.0 && tick < ticks / 2 && random.Uniform(0.0, 1.0) < c.late)
      next += random.Uniform(0.0, kMostLateTick_s);
    dt = std::max(next - now, kLeastTick);
    const int substeps = static_cast<int>(std::ceil(dt / kSubstep - 1e-6));
    const double h = dt / substeps;
    for (int i = 0; i < substeps; ++i) {
      const double t = now + i * h;
      const double aim = target(t), aim_v = (target(t + 1e-6) - target(t - 1e-6)) / 2e-6;
      double p = kMass * v + h * (held + kSpring * (aim - z) + kDamper * (aim_v - v));
      const double brake = h * kFriction;
      p = std::abs(p) <= brake ? 0.0 : p - std::copysign(brake, p);
      v = p / kMass;
      z += h * v;
    }
    now += dt;
    figures.fastest_m_s = std::max(figures.fastest_m_s, std::abs(v));
    figures.deepest_m = std::max(figures.deepest_m, -z);
  }
  if (contact_ticks > 0) {
    figures.rms_change_N = std::sqrt(squares / static_cast<double>(contact_ticks));
    figures.rms_wanted_N = std::sqrt(wanted_squares / static_cast<double>(contact_ticks));
  }
  return figures;
}

}  // namespace palpate::test
