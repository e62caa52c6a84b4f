#pragma once

#include <string>
#include <utility>

#include "client/station/guide.h"
#include "common/dds/endpoint.h"
#include "common/dds/participant.h"
#include "common/dds/topics.h"

namespace palpate {

/// Receives the aims of the guide that leads this station, if there is one.
/// Thread contract: one thread, not the servo thread.
class GuideLink {
 public:
  /// @param service  must outlive it.   Throws Error.
  GuideLink(const dds::Participant& service, std::string station)
      : station_(std::move(station)), targets_(service, dds::kGuideTopic, dds::Qos::kStream) {}

  /// Calls take(aim) with the newest aim that has arrived, if any.
  template <class Take>
  void Poll(Take take) {
    wire::GuideTarget target{};
    GuideAim aim;
    bool any = false;
    while (targets_.Take(target)) {
      if (station_ != target.station) continue;
      aim = {target.run, wire::ToPose(target.position_m, target.orientation_wxyz)};
      any = true;
    }
    if (any) take(aim);
  }

 private:
  std::string station_;
  dds::Reader<wire::GuideTarget> targets_;
};

}  // namespace palpate
