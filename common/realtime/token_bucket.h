#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace palpate {

/// So much of something in the long run, and so much at once after a rest (the generic cell rate
/// algorithm: a bucket that fills at a rate, kept as the time up to which it is paid).
/// Time is given [ns].  Real-time: no allocation, lock or log.  Thread contract: one thread.
class TokenBucket {
 public:
  /// @param per_second  units in the long run, more than zero.   @param at_once  units.
  TokenBucket(double per_second, double at_once) noexcept
      : unit_ns_(1e9 / per_second), slack_ns_(static_cast<std::int64_t>(at_once * unit_ns_)) {}

  /// Takes one; false where there is none.
  bool Take(std::int64_t now_ns) noexcept {
    if (WaitFor(1.0, now_ns) > 0) return false;
    Spend(1.0, now_ns);
    return true;
  }
  /// How long until `units` are there [ns]; 0: they are.
  std::int64_t WaitFor(double units, std::int64_t now_ns) const noexcept {
    return std::max<std::int64_t>(0, PaidUntil(now_ns) + Cost(units) - now_ns);
  }
  /// Takes them, there or not: what came first has been done, and is paid for by waiting.
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
