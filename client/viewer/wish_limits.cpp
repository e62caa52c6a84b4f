#include "client/viewer/wish_limits.h"

#include "client/viewer/viewer_limits.h"

namespace palpate {
namespace {

const ViewerLimits::Wish& LimitsOf(Wish wish) {
  switch (wish) {
    case Wish::kTake:
      return ViewerLimits::kTake;
    case Wish::kWhole:
      return ViewerLimits::kWhole;
    case Wish::kReplay:
      return ViewerLimits::kReplay;
    case Wish::kOperate:
      return ViewerLimits::kOperate;
    case Wish::kSubscribe:
      break;
  }
  return ViewerLimits::kSubscribe;
}

RateLimit LimitOf(const ViewerLimits::Rate& rate) {
  return RateLimit(rate.period_ns, rate.at_once);
}

RateLimit OfViewer(Wish wish) {
  return LimitOf(LimitsOf(wish).of_viewer);
}

}  // namespace

WishLimits::Verdict WishLimits::Ask(Wish wish, std::uint64_t viewer, const std::string& address,
                                    std::int64_t now_ns) {
  // Those that have rested need not be remembered.
  std::erase_if(addresses_, [&](const auto& entry) { return entry.second.IsRested(now_ns); });
  auto known = viewers_.find(viewer);
  if (known == viewers_.end()) {
    const Viewer fresh{{OfViewer(Wish::kTake), OfViewer(Wish::kWhole), OfViewer(Wish::kReplay),
                        OfViewer(Wish::kOperate), OfViewer(Wish::kSubscribe)},
                       {}};
    known = viewers_.emplace(viewer, fresh).first;
  }
  const auto index = static_cast<std::size_t>(wish);
  RateLimit& own = known->second.limits[index];
  bool& told = known->second.told[index];
  if (own.IsRested(now_ns)) told = false;
  if (own.Pass(now_ns) &&
      addresses_.try_emplace({address, wish}, LimitOf(LimitsOf(wish).of_address))
          .first->second.Pass(now_ns)) {
    return {true, false};
  }
  return {false, !std::exchange(told, true)};
}

const char* TooOften(Wish wish) {
  switch (wish) {
    case Wish::kTake:
      return "tools are taken too often from here; wait some seconds";
    case Wish::kWhole:
      return "scenes are made whole too often from here; wait some seconds";
    case Wish::kReplay:
      return "a replay is steered too often from here; wait a second";
    case Wish::kOperate:
      return "stations are decided about too often from here; wait some seconds";
    case Wish::kSubscribe:
      break;
  }
  return "channels are subscribed to too often from here; wait some seconds and subscribe again";
}

}  // namespace palpate
