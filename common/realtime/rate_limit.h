#pragma once

#include <cstdint>
#include <utility>

#include "common/realtime/token_bucket.h"

namespace palpate {

/// Lets some pass at once and then one each period, and counts those that it holds back: for what
/// outsiders can bring about as often as they like, as a line of the log or a process.
/// Thread contract: one thread.  Time is given [ns], and never goes back.
class RateLimit {
 public:
  static constexpr std::int64_t kSecond_ns = 1'000'000'000;

  /// @param at_once    how many may come together after a rest.
  explicit RateLimit(std::int64_t period_ns = kSecond_ns, int at_once = 1)
      : bucket_(1e9 / static_cast<double>(period_ns), at_once), at_once_(at_once) {}

  /// True where one more may pass now.
  bool Pass(std::int64_t now_ns) {
    const bool passes = bucket_.Take(now_ns);
    held_back_ += !passes;
    return passes;
  }
  /// As many have been held back since this was last asked.
  std::uint64_t TakeHeldBack() { return std::exchange(held_back_, 0); }
  /// Some were held back, and there is room again: who counts them may say so now.
  bool OwesWord(std::int64_t now_ns) const {
    return held_back_ > 0 && bucket_.WaitFor(1.0, now_ns) == 0;
  }
  /// As if none had ever come: it need not be kept.
  bool IsRested(std::int64_t now_ns) const { return bucket_.WaitFor(at_once_, now_ns) == 0; }

 private:
  TokenBucket bucket_;
  double at_once_;
  std::uint64_t held_back_ = 0;
};

}  // namespace palpate
