#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "devices/wrench_limiter.h"
#include "tests/support/random.h"

namespace palpate::test {

/// The greatest outputs obtained from a limiter, relative to its limits.
struct LimiterTally {
  std::uint64_t inputs = 0;
  std::uint64_t nonfinite = 0;  ///< outputs
  double force = 0.0;
  double torque = 0.0;
  double force_slew = 0.0;
  double torque_slew = 0.0;
  LimiterCounts counts;
};

/// Tries deterministically to get more out of a limiter than its limits allow, in turn by:
/// - random: anything, such as non-finite, denormal or huge values, leaping poses and clocks that
/// stand or run back;
/// - bang: a hand that is thrown about, with forces along or against its velocity at ten times the
/// peak, guide likewise, and silence, age and enable switched at the worst time;
/// - climb: of several next inputs, always the one that brings the output nearest to a limit.
class LimiterAdversary {
 public:
  LimiterAdversary(const WrenchLimits& limits, std::uint64_t seed)
      : limits_(limits), random_(seed), limiter_(limits) {}

  LimiterTally Run(std::uint64_t inputs) {
    while (tally_.inputs < inputs) {
      AddCounts();
      limiter_ = WrenchLimiter(limits_);
      // The stiffness is unknown at first; a session may set any value.
      if (random_.Below(4) != 0) limiter_.SetStiffness(Stiffness());
      last_ = Wrench{};
      X_WH_ = Pose{};
      velocity_ = Vec3::Zero();
      silence_s_ = age_s_ = 0.0;
      aimed_at_ = random_.Below(4);
      const int way = random_.Below(3);
      // Long enough for the ramps to end, and sometimes for the motors to warm.
      const int stretch = 1000 + random_.Below(random_.Below(20) == 0 ? 60'000 : 3000);
      for (int i = 0; i < stretch && tally_.inputs < inputs; ++i) {
        if (way == 0) {
          Try(Anything());
        } else if (way == 1) {
          Try(Thrown());
        } else {
          Climb();
        }
      }
    }
    AddCounts();
    return tally_;
  }

 private:
  static constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  static constexpr double kInf = std::numeric_limits<double>::infinity();

  double Unit() { return random_.Uniform(-1.0, 1.0); }
  template <std::size_t N>
  double OneOf(const std::array<double, N>& values) {
    return values[static_cast<std::size_t>(random_.Below(static_cast<int>(N)))];
  }
  double Number() {
    switch (random_.Below(4)) {
      case 0:
        return OneOf(std::array{0.0, -0.0, kNan, kInf, -kInf, 1e308, -1e308, 1e-308, 5e-324,
                                -5e-324, 22.0, -22.0});
      case 1:
        return std::ldexp(Unit(), random_.Below(2000) - 1000);
      case 2:
        return random_.Below(2) ? 1e3 : -1e3;
      default:
        return 30.0 * Unit();
    }
  }
  double Stiffness() { return random_.Below(4) == 0 ? Number() : random_.Uniform(10.0, 2e4); }
  Vec3 Vector() {
    const double x = Number(), y = Number();
    return {x, y, Number()};
  }

  LimiterInput Anything() {
    if (random_.Below(300) == 0) limiter_.Enable(random_.Below(8) != 0);
    const bool calm = random_.Below(4) != 0;  // otherwise the ramps would never end
    LimiterInput in;
    in.wanted = {Vector(), Vector()};
    if (random_.Below(2)) in.led = {Vector(), Vector()};
    in.X_WH = {random_.InCube(0.1), random_.Rotation()};
    if (random_.Below(10) == 0) in.X_WH.p = Vector();
    if (random_.Below(10) == 0) in.X_WH.q = Quat(Number(), Number(), Number(), Number());
    in.V_WH = {Vector(), Vector()};
    const std::array times = {0.0,   0.5e-3, 3.9e-3, 4.1e-3, 0.011, 0.0249, 0.025, 0.059,
                              0.061, 0.0999, 0.1,    1.0,    -1.0,  kInf,   kNan,  1e308};
    in.silence_s = calm ? 1e-3 : OneOf(times);
    in.age_s = calm ? 1e-3 : OneOf(times);
    in.dt_s = calm ? 1e-3
                   : OneOf(std::array{1e-3, 2.5e-4, 0.0, 2e-3, 1.0, -1.0, kNan, kInf, 1e-9, 1e-6,
                                      9.99e-7, 5e-324, -1e308});
    in.motor_temperature = random_.Below(3) ? kNan : Number();
    in.entering = random_.Below(5) == 0;
    if (random_.Below(1000) == 0) limiter_.SetStiffness(Stiffness());
    return in;
  }

  /// Returns the input of a hand thrown about in virtual time; the force follows its velocity.
  LimiterInput Thrown() {
    constexpr double kTick = 1e-3;
    if (random_.Below(50) == 0) velocity_ = 0.5 * random_.Direction();
    if (random_.Below(50) == 0) velocity_ = -velocity_;
    if (random_.Below(100) == 0) limiter_.Enable(random_.Below(4) != 0);
    X_WH_.p += kTick * velocity_;
    X_WH_.q = (RotationExp(kTick * 10.0 * velocity_) * X_WH_.q).normalized();
    if (X_WH_.p.norm() > 0.2) velocity_ = -0.5 * X_WH_.p.normalized();
    silence_s_ = random_.Below(60) == 0 ? 0.03 * random_.Uniform(0.0, 1.0) : silence_s_ + kTick;
    if (random_.Below(3) != 0) silence_s_ = std::min(silence_s_, 3e-3);
    if (random_.Below(100) == 0) age_s_ = 0.12 * random_.Uniform(0.0, 1.0);
    if (random_.Below(4) == 0) age_s_ = 0.0;
    LimiterInput in;
    const double along =
        random_.Below(5) == 0 ? 10.0 : -10.0;  // mostly against the motion, which fills the store
    const Vec3 direction = velocity_.norm() > 0.0 ? Vec3(2.0 * velocity_) : random_.Direction();
    in.wanted = {along * limits_.force_N() * direction, along * limits_.torque_Nm() * direction};
    const double led = random_.Below(2) ? 1e3 : -1e3;
    in.led = {led * direction, led * direction};
    in.X_WH = X_WH_;
    in.V_WH = {velocity_, 10.0 * velocity_};
    in.silence_s = silence_s_;
    in.age_s = age_s_;
    in.dt_s = kTick;
    in.entering = random_.Below(5) == 0;
    return in;
  }

  void Climb() {
    const WrenchLimiter here = limiter_;
    const Wrench last = last_;
    WrenchLimiter best = limiter_;
    Wrench best_output;
    double best_ratio = -1.0;
    const auto consider = [&](const LimiterInput& in, bool enabled) {
      limiter_ = here;
      last_ = last;
      limiter_.Enable(enabled);
      const std::array ratios = Try(in);
      // One aim per stretch: the largest output, or the largest change.
      const double ratio = ratios[static_cast<std::size_t>(aimed_at_)] + 0.2 * ratios[0];
      if (ratio > best_ratio) {
        best_ratio = ratio;
        best = limiter_;
        best_output = last_;
      }
    };
    LimiterInput in = Thrown();
    const bool enabled = here.enabled() || random_.Below(20) == 0;
    for (const double sign : {1.0, -1.0}) {
      in.wanted.force *= sign;
      in.wanted.torque *= sign;
      in.silence_s = in.age_s = 0.0;
      consider(in, enabled);
      in.silence_s = silence_s_;
      consider(in, enabled);
      in.silence_s = OneOf(std::array{0.012, 0.0145, 0.02, 1.0});
      consider(in, !enabled);
      in.motor_temperature = 1.0;
      in.led = {-in.led.force, -in.led.torque};
      consider(in, !enabled);
      in.motor_temperature = kNan;
    }
    limiter_ = best;
    last_ = best_output;
  }

  /// Runs the limiter; returns force, torque and their changes relative to the limits.
  std::array<double, 4> Try(const LimiterInput& in) {
    const Wrench out = limiter_.Limit(in).wrench();
    ++tally_.inputs;
    if (!out.force.allFinite() || !out.torque.allFinite()) {
      ++tally_.nonfinite;
      return {kInf, kInf, kInf, kInf};
    }
    const double dt = CountedTick(in.dt_s);
    const auto over = [](double amount, double limit) {
      return amount == 0.0 ? 0.0 : amount / limit;  // zero change in zero time is allowed
    };
    const std::array ratios = {
        out.force.norm() / limits_.force_N(), out.torque.norm() / limits_.torque_Nm(),
        over((out.force - last_.force).norm(), 1e3 * limits_.force_slew_N_per_ms() * dt),
        over((out.torque - last_.torque).norm(), 1e3 * limits_.torque_slew_Nm_per_ms() * dt)};
    tally_.force = std::max(tally_.force, ratios[0]);
    tally_.torque = std::max(tally_.torque, ratios[1]);
    tally_.force_slew = std::max(tally_.force_slew, ratios[2]);
    tally_.torque_slew = std::max(tally_.torque_slew, ratios[3]);
    last_ = out;
    return ratios;
  }

  void AddCounts() {
    const LimiterCounts now = limiter_.counts();
    LimiterCounts& sum = tally_.counts;
    sum.calls += now.calls;
    sum.nonfinite += now.nonfinite;
    sum.clamped += now.clamped;
    sum.slewed += now.slewed;
    sum.braked += now.braked;
    sum.warm += now.warm;
    sum.faded += now.faded;
    sum.fades += now.fades;
    sum.disabled += now.disabled;
  }

  WrenchLimits limits_;
  Random random_;
  WrenchLimiter limiter_;
  Wrench last_;
  Pose X_WH_;
  Vec3 velocity_ = Vec3::Zero();
  double silence_s_ = 0.0, age_s_ = 0.0;
  int aimed_at_ = 0;
  LimiterTally tally_;
};

}  // namespace palpate::test
