#pragma once

#include <cstdint>

#include "devices/limiter/vector_bound.h"

namespace palpate {

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

}  // namespace palpate
