#pragma once

#include <algorithm>
#include <cstdint>

#include "common/realtime/token_bucket.h"

namespace palpate {

/// A station's share of the thread that answers all stations, in poses and in time.  Without it, a
/// station that sends ten times as many poses as it should, or whose tool is where steps are
/// expensive, would delay all others.  A pose beyond the share is dropped as if the network had
/// lost it; the physics never sees it, so a replay needs no record of it.
/// Real-time: no allocation, lock or log.
class ServoBudget {
 public:
  static constexpr std::int64_t kPosesPerSecond = 1250;  ///< stations send 1000
  static constexpr std::int64_t kPosesAtOnce = 100;      ///< after a stall
  /// Share of the thread's time if others want it too: a half.  Who shares with one other then gets
  /// no less than a fair scheduler would give, and a step may cost 0.5 ms on average.
  static constexpr double kShare = 0.5;
  static constexpr double kAtOnce_s = 0.05;
  /// A step that takes longer than this was held up by the machine; the rest is not counted.
  static constexpr std::int64_t kLongest_ns = 5'000'000;

  explicit ServoBudget(double share = kShare) noexcept
      : poses_(kPosesPerSecond, kPosesAtOnce), time_(share, kAtOnce_s) {}

  /// Returns whether a pose may be answered; false if the share is used up.
  /// @param alone  nobody else wants the thread, so all its time is the station's
  bool Take(std::int64_t now_ns, bool alone) noexcept {
    return (alone || WaitForTime(now_ns) == 0) && poses_.Take(now_ns);
  }
  /// Returns the time until the station has time again [ns]; 0 if it has.
  std::int64_t WaitForTime(std::int64_t now_ns) const noexcept {
    return time_.WaitFor(0.0, now_ns);
  }
  /// Counts the time of a step.
  void Took(std::int64_t step_ns, std::int64_t now_ns) noexcept {
    time_.Spend(1e-9 * static_cast<double>(std::min(step_ns, kLongest_ns)), now_ns);
  }

 private:
  TokenBucket poses_;
  TokenBucket time_;  // in seconds
};

}  // namespace palpate
