#pragma once

#include <cstdint>

#include "devices/limiter/vector_bound.h"

namespace palpate {

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

}  // namespace palpate
