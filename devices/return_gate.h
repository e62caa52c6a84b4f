#pragma once

#include <cstdint>

#include "common/math/pose.h"

namespace palpate {

/// Whether an arm that has no frames of its own gets what the limiter let through.  Below the
/// limiter, as a fault of the arm takes its force away in the same tick, where the limiter would
/// ramp out.  Closed from the beginning, and from each Fault on, until 0.1 s without one have
/// passed *and* the limiter asks for nothing at all: a closed gate is a fault to the station, so
/// the limiter gets there by itself, and the force comes back by its ramp, never by a step.
/// Counts ticks, reads no clock.  Real-time.  Not thread-safe: the tick's thread owns it.
class ReturnGate {
 public:
  static constexpr double kQuiet_s = 0.1;

  explicit ReturnGate(double rate_Hz)
      : quiet_needed_(static_cast<std::uint64_t>(kQuiet_s * rate_Hz)) {}

  void Fault() noexcept {
    open_ = false;
    quiet_ticks_ = 0;
  }
  /// Once per tick: whether this wrench may go out.
  bool Passes(const Wrench& limited) noexcept {
    ++quiet_ticks_;
    const bool nothing = limited.force.isZero(0.0) && limited.torque.isZero(0.0);
    if (!open_ && nothing && quiet_ticks_ > quiet_needed_) open_ = true;
    return open_;
  }
  bool open() const noexcept { return open_; }

 private:
  std::uint64_t quiet_needed_;
  std::uint64_t quiet_ticks_ = 0;
  bool open_ = false;
};

}  // namespace palpate
