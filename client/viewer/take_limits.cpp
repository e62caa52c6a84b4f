#include "client/viewer/take_limits.h"

namespace palpate {

bool TakeLimits::Pass(std::uint64_t viewer, const std::string& address, std::int64_t now_ns) {
  // Those that have rested need not be remembered: what is kept are addresses of the last seconds.
  std::erase_if(addresses_, [&](const auto& entry) { return entry.second.IsRested(now_ns); });
  RateLimit& own = viewers_.try_emplace(viewer, RateLimit(kPeriod_ns, kAtOnce)).first->second;
  if (!own.Pass(now_ns)) return false;
  RateLimit& all =
      addresses_.try_emplace(address, RateLimit(kPeriodOfAnAddress_ns, kAtOnceOfAnAddress))
          .first->second;
  return all.Pass(now_ns);
}

}  // namespace palpate
