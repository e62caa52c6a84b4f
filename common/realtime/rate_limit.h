#pragma once

#include <cstdint>
#include <utility>

#include "common/realtime/token_bucket.h"

namespace palpate {

/// Rate limiter: passes a burst of events and then one per period, and counts those that it holds
/// back.  For actions that outsiders can trigger as often as they like, such as log lines or
/// processes.
/// Thread contract: one thread.  The caller passes the time [ns], which never goes back.
class RateLimit {
 public:
  static constexpr std::int64_t kSecond_ns = 1'000'000'000;

  /// @param at_once    size of the burst that passes after a rest.
  explicit RateLimit(std::int64_t period_ns = kSecond_ns, int at_once = 1)
      : bucket_(1e9 / static_cast<double>(period_ns), at_once), at_once_(at_once) {}

  /// Returns true if one more event may pass now.
  bool Pass(std::int64_t now_ns) {
    const bool passes = bucket_.Take(now_ns);
    held_back_ += !passes;
    return passes;
  }
  /// Returns how many were held back since the last call.
  std::uint64_t TakeHeldBack() { return std::exchange(held_back_, 0); }
  /// Returns true if events were held back and there is room again, so that their number can be
  /// reported now.
  bool OwesWord(std::int64_t now_ns) const {
    return held_back_ > 0 && bucket_.WaitFor(1.0, now_ns) == 0;
  }
  /// Returns true if the state is that of a new limiter, so that this one can be discarded.
  bool IsRested(std::int64_t now_ns) const { return bucket_.WaitFor(at_once_, now_ns) == 0; }

 private:
  TokenBucket bucket_;
  double at_once_;
  std::uint64_t held_back_ = 0;
};

}  // namespace palpate
