#pragma once

#include <cstdint>
#include <string>

#include "client/station/guide.h"
#include "common/dds/endpoint.h"
#include "common/dds/participant.h"

namespace palpate {

/// Hears the guide that leads this station, if there is one.
/// Thread contract: one thread, not the servo thread.
class GuideLink {
 public:
  /// Throws Error.
  GuideLink(int domain, const dds::Network& network, std::string station);

  /// Calls take(aim) for the newest that has come, if any.
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
  dds::Participant service_;
  dds::Reader<wire::GuideTarget> targets_;
};

}  // namespace palpate
