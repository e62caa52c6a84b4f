#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace palpate {

/// A station's share of the thread that answers all stations: 1250 poses a second, and 100 at once
/// after a stall.  A station that sends ten times what it should would make everybody late.  A pose
/// beyond the share is as one that was lost on its way: never heard, so a replay need not know.
/// Real-time: no allocation, lock or log.
class PoseBudget {
 public:
  static constexpr std::int64_t kPerSecond = 1250;  ///< stations send 1000
  static constexpr std::int64_t kAtOnce = 100;

  /// False where the share is used up.
  bool Take(std::int64_t now_ns) noexcept {
    paid_until_ns_ = std::max(paid_until_ns_, now_ns - kAtOnce * kPose_ns);
    if (paid_until_ns_ + kPose_ns > now_ns) return false;
    paid_until_ns_ += kPose_ns;
    return true;
  }

 private:
  static constexpr std::int64_t kPose_ns = 1'000'000'000 / kPerSecond;
  std::int64_t paid_until_ns_ = std::numeric_limits<std::int64_t>::min() / 2;
};

}  // namespace palpate
