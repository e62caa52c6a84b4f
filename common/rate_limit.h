#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

namespace palpate {

/// Lets some pass at once and then one each period, and counts those that it holds back: for what
/// outsiders can bring about as often as they like, as a line of the log or a process.
/// Thread contract: one thread.  Time is given [ns], and never goes back.
class RateLimit {
 public:
  static constexpr std::int64_t kSecond_ns = 1'000'000'000;

  /// @param at_once    how many may come together after a rest.
  explicit RateLimit(std::int64_t period_ns = kSecond_ns, int at_once = 1)
      : period_ns_(period_ns), at_once_(at_once) {}

  /// True where one more may pass now.
  bool Pass(std::int64_t now_ns) {
    if (!HasRoom(now_ns)) {
      ++held_back_;
      return false;
    }
    // Each that passes takes a period, counted from now or from where the last ones' ends.
    free_ns_ = std::max(free_ns_, now_ns) + period_ns_;
    return true;
  }
  /// As many have been held back since this was last asked.
  std::uint64_t TakeHeldBack() { return std::exchange(held_back_, 0); }
  /// Some were held back, and there is room again: who counts them may say so now.
  bool OwesWord(std::int64_t now_ns) const { return held_back_ > 0 && HasRoom(now_ns); }
  /// As if none had ever come: it need not be kept.
  bool IsRested(std::int64_t now_ns) const { return free_ns_ <= now_ns; }

 private:
  bool HasRoom(std::int64_t now_ns) const {
    return std::max(free_ns_, now_ns) - now_ns <= (at_once_ - 1) * period_ns_;
  }

  std::int64_t period_ns_;
  int at_once_;
  std::int64_t free_ns_ = 0;  // when all that have passed have had their periods
  std::uint64_t held_back_ = 0;
};

}  // namespace palpate
