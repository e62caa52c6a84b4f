#pragma once

#include <algorithm>
#include <cstdint>

#include "devices/limiter/vector_bound.h"

namespace palpate {

/// A wrench with NaN or infinity in it counts as zero.
class FiniteStage {
 public:
  Wrench Pass(const Wrench& wrench) noexcept {
    if (wrench.force.allFinite() && wrench.torque.allFinite()) return wrench;
    ++count_;
    return {};
  }
  std::uint64_t count() const noexcept { return count_; }

 private:
  std::uint64_t count_ = 0;
};

/// Shortens force and torque to their peak, direction kept.
class ClampStage {
 public:
  ClampStage(double force_N, double torque_Nm) : force_N_(force_N), torque_Nm_(torque_Nm) {}

  Wrench Pass(Wrench wrench) noexcept {
    const bool force = Shorten(wrench.force, force_N_);
    const bool torque = Shorten(wrench.torque, torque_Nm_);
    count_ += force || torque;
    return wrench;
  }
  std::uint64_t count() const noexcept { return count_; }

 private:
  double force_N_, torque_Nm_;
  std::uint64_t count_ = 0;
};

/// Follows what it is given at a bounded rate, from zero on.
class SlewStage {
 public:
  /// @param force_N_s, torque_Nm_s  rates.
  SlewStage(double force_N_s, double torque_Nm_s)
      : force_N_s_(force_N_s), torque_Nm_s_(torque_Nm_s) {}

  /// @param felt  false: what it gave last was not rendered, so it may leap to the target.
  const Wrench& Pass(const Wrench& target, double dt_s, bool felt = true) noexcept {
    if (!felt) return value_ = target;
    const bool force = MoveTowards(value_.force, target.force, force_N_s_ * dt_s);
    const bool torque = MoveTowards(value_.torque, target.torque, torque_Nm_s_ * dt_s);
    count_ += force || torque;
    return value_;
  }
  std::uint64_t count() const noexcept { return count_; }
  double force_N_s() const noexcept { return force_N_s_; }
  double torque_Nm_s() const noexcept { return torque_Nm_s_; }

 private:
  double force_N_s_, torque_Nm_s_;
  Wrench value_;
  std::uint64_t count_ = 0;
};

/// A factor that starts at 0, ramps to 1 when forces are asked for, and back sooner than that.
class EnableStage {
 public:
  static constexpr double kRampIn_s = 0.200;
  static constexpr double kRampOut_s = 0.050;
  static constexpr double kFastest_1_s = 1.0 / kRampOut_s;

  void Enable(bool on) noexcept { enabled_ = on; }
  bool enabled() const noexcept { return enabled_; }

  double Gain(double dt_s) noexcept {
    gain_ = enabled_ ? std::min(1.0, gain_ + dt_s / kRampIn_s)
                     : std::max(0.0, gain_ - dt_s / kRampOut_s);
    count_ += gain_ < 1.0;
    return gain_;
  }
  /// Calls with less than the whole wrench.
  std::uint64_t count() const noexcept { return count_; }

 private:
  bool enabled_ = false;
  double gain_ = 0.0;
  std::uint64_t count_ = 0;
};

}  // namespace palpate
