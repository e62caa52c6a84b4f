#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "common/realtime/rate_limit.h"

namespace palpate {

/// Requests of viewers that cost more than their bytes.
enum class Wish { kTake, kWhole, kReplay, kOperate, kSubscribe };

/// Limits how often viewers may have a wish, with the rates of ViewerLimits: per viewer, and for
/// all viewers of an address together.
/// Thread contract: one thread.  Times are in nanoseconds.
class WishLimits {
 public:
  struct Verdict {
    bool granted = false;
    /// It is refused, and the viewer has not been told since it last rested: a loop is told once.
    bool tell = false;
  };
  /// Decides whether this viewer may have this wish now, and counts it if so.
  Verdict Ask(Wish wish, std::uint64_t viewer, const std::string& address, std::int64_t now_ns);
  void Leave(std::uint64_t viewer) { viewers_.erase(viewer); }

  /// Number of addresses remembered: those of the last seconds.
  std::size_t addresses() const { return addresses_.size(); }

 private:
  static constexpr std::size_t kKinds = 5;
  struct Viewer {
    std::array<RateLimit, kKinds> limits;
    std::array<bool, kKinds> reported{};
  };
  std::map<std::uint64_t, Viewer> viewers_;
  std::map<std::pair<std::string, Wish>, RateLimit> addresses_;
};

/// Returns the reason of a refusal, for the viewer.
const char* TooOften(Wish wish);

}  // namespace palpate
