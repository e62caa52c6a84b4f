#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace palpate {

/// Limits the long-run rate of something, and the burst after a rest (generic cell rate algorithm:
/// a bucket that fills at a rate, stored as the time up to which it is paid).
/// The caller passes the time [ns].  Real-time: no allocation, lock or log.  Thread contract:
/// one thread.
class TokenBucket {
 public:
  /// @param per_second  units per second in the long run, more than zero.
  /// @param at_once  units in a burst.
  TokenBucket(double per_second, double at_once) noexcept
      : unit_ns_(1e9 / per_second), slack_ns_(static_cast<std::int64_t>(at_once * unit_ns_)) {}

  /// Takes one unit; false if there is none.
  bool Take(std::int64_t now_ns) noexcept {
    if (WaitFor(1.0, now_ns) > 0) return false;
    Spend(1.0, now_ns);
    return true;
  }
  /// Returns how long it takes until `units` are available [ns]; 0 if they are.
  std::int64_t WaitFor(double units, std::int64_t now_ns) const noexcept {
    return std::max<std::int64_t>(0, PaidUntil(now_ns) + Cost(units) - now_ns);
  }
  /// Takes the units even if they are not available: the work is done already, and later calls wait
  /// longer for it.
  void Spend(double units, std::int64_t now_ns) noexcept {
    paid_until_ns_ = PaidUntil(now_ns) + Cost(units);
  }

 private:
  std::int64_t Cost(double units) const noexcept {
    return static_cast<std::int64_t>(units * unit_ns_);
  }
  std::int64_t PaidUntil(std::int64_t now_ns) const noexcept {
    return std::max(paid_until_ns_, now_ns - slack_ns_);
  }

  double unit_ns_;
  std::int64_t slack_ns_;
  std::int64_t paid_until_ns_ = std::numeric_limits<std::int64_t>::min() / 2;
};

}  // namespace palpate
