#include "client/viewer/wish_limits.h"

#include "client/viewer/viewer_limits.h"

namespace palpate {
namespace {

struct Limited {
  ViewerLimits::Wish limits;
  const char* too_often;
};
/// In the order of Wish.
constexpr Limited kWishes[] = {
    {ViewerLimits::kTake, "tools are taken too often from here; wait some seconds"},
    {ViewerLimits::kWhole, "scenes are made whole too often from here; wait some seconds"},
    {ViewerLimits::kReplay, "a replay is steered too often from here; wait a second"},
    {ViewerLimits::kOperate, "stations are decided about too often from here; wait some seconds"},
    {ViewerLimits::kSubscribe,
     "channels are subscribed to too often from here; wait some seconds and subscribe again"}};

RateLimit LimitOf(const ViewerLimits::Rate& rate) {
  return RateLimit(rate.period_ns, rate.at_once);
}

}  // namespace

WishLimits::Verdict WishLimits::Ask(Wish wish, std::uint64_t viewer, const std::string& address,
                                    std::int64_t now_ns) {
  // Addresses that have rested need not be remembered.
  std::erase_if(addresses_, [&](const auto& entry) { return entry.second.IsRested(now_ns); });
  const auto [known, is_new] = viewers_.try_emplace(viewer);
  for (std::size_t i = 0; is_new && i < kKinds; ++i) {
    known->second.limits[i] = LimitOf(kWishes[i].limits.of_viewer);
  }
  const auto index = static_cast<std::size_t>(wish);
  RateLimit& own = known->second.limits[index];
  bool& reported = known->second.reported[index];
  if (own.IsRested(now_ns)) reported = false;
  if (own.Pass(now_ns) &&
      addresses_.try_emplace({address, wish}, LimitOf(kWishes[index].limits.of_address))
          .first->second.Pass(now_ns)) {
    return {true, false};
  }
  return {false, !std::exchange(reported, true)};
}

const char* TooOften(Wish wish) {
  return kWishes[static_cast<std::size_t>(wish)].too_often;
}

}  // namespace palpate
