#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "common/realtime/rate_limit.h"

namespace palpate {

/// What viewers ask for that costs more than its bytes.
enum class Wish { kTake, kWhole, kReplay, kOperate, kSubscribe };

/// How often viewers may have such a wish, by the figures of ViewerLimits: each of its own, and all
/// of an address together.
/// Thread contract: one thread.  Time is given [ns].
class WishLimits {
 public:
  struct Verdict {
    bool granted = false;
    /// It is refused and has not been told so since it last rested: a loop is told once.
    bool tell = false;
  };
  /// Whether this viewer may have this wish now, which then counts.
  Verdict Ask(Wish wish, std::uint64_t viewer, const std::string& address, std::int64_t now_ns);
  void Leave(std::uint64_t viewer) { viewers_.erase(viewer); }

  /// Addresses that are remembered: those of the last seconds.
  std::size_t addresses() const { return addresses_.size(); }

 private:
  static constexpr std::size_t kKinds = 5;
  struct Viewer {
    std::array<RateLimit, kKinds> limits;
    std::array<bool, kKinds> told{};
  };
  std::map<std::uint64_t, Viewer> viewers_;
  std::map<std::pair<std::string, Wish>, RateLimit> addresses_;
};

/// Why a wish is refused, for who has it.
const char* TooOften(Wish wish);

}  // namespace palpate
