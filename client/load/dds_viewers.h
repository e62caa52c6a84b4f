#pragma once

#include <cstddef>
#include <list>

#include "client/load/frame_tally.h"
#include "common/dds/endpoint.h"

namespace palpate {

/// Viewers that read ToolState themselves, each a participant of its own; they share this process's
/// receiving thread.
class DdsViewers {
 public:
  /// The tally must outlive it.  Throws Error.
  DdsViewers(int domain, const dds::Network& network, std::size_t viewers, FrameTally& tally);

 private:
  struct Viewer {
    dds::Participant participant;
    dds::Reader<wire::ToolState> reader;
  };
  std::list<Viewer> viewers_;
};

}  // namespace palpate
