#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "common/rate_limit.h"

namespace palpate {

/// How often tools may be taken with the mouse: each take starts a process, and ends one before
/// long.  A hand takes a tool, gives it back and takes another within seconds now and then; only a
/// loop does so on and on.
/// Thread contract: one thread.  Time is given [ns].
class TakeLimits {
 public:
  /// Of a viewer: some at once, then one in two seconds.
  static constexpr int kAtOnce = 5;
  static constexpr std::int64_t kPeriod_ns = 2'000'000'000;
  /// Of an address, which a class may share, and which makes as many viewers as it likes: as many
  /// as there may be mice, at once, then two a second.
  static constexpr int kAtOnceOfAnAddress = 16;
  static constexpr std::int64_t kPeriodOfAnAddress_ns = 500'000'000;

  /// True where this viewer may take a tool now, which then counts.
  bool Pass(std::uint64_t viewer, const std::string& address, std::int64_t now_ns);
  void Leave(std::uint64_t viewer) { viewers_.erase(viewer); }

 private:
  std::map<std::uint64_t, RateLimit> viewers_;
  std::map<std::string, RateLimit> addresses_;
};

}  // namespace palpate
