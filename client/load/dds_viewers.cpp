#include "client/load/dds_viewers.h"

#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"

namespace palpate {

DdsViewers::DdsViewers(int domain, const dds::Network& network, std::size_t viewers,
                       FrameTally& tally) {
  for (std::size_t i = 0; i < viewers; ++i) {
    Viewer& viewer = viewers_.emplace_back(Viewer{dds::Participant::Service(domain, network), {}});
    viewer.reader = {
        viewer.participant, dds::kToolStateTopic, dds::Qos::kStream,
        [i, &tally](const wire::ToolState& frame) { tally.Add(i, frame, SteadyNanoseconds()); }};
  }
}

}  // namespace palpate
