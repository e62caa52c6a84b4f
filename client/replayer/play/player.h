#pragma once

#include "client/replayer/playback.h"
#include "common/program/stop_signal.h"

namespace palpate {

struct PlayOptions {
  bool stepping = false;  ///< begins paused
  bool locked = false;    ///< viewers may not steer
  bool stays = false;     ///< waits at the end
};

/// Publishes a recording's service topics to viewers as a server would, at the pace that they had,
/// until its end, a signal or `q`.  Poses and wrenches stay in the recording.  Throws Error: where
/// a server runs in the domain, or nothing in the recording is for viewers.
void Play(const Playback& playback, const PlayOptions& options, StopSignal& stop);

}  // namespace palpate
