#pragma once

#include <optional>
#include <string>

#include "client/replayer/hand_path.h"
#include "client/replayer/score/performance.h"
#include "client/replayer/verify/verify.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// What the tool of a recorded session cut, from where it was (CutSweep); none where that is not
/// known so.  Throws Error where the file cannot be read.
/// @param path  the session; its way is not asked for.   @param played  its scene.
/// @param stop  null: all of the recording is there; else it is being made, and is waited for
///              until its end, or a signal.
std::optional<SolidsCut> SweptIn(const std::string& file, const HandPath& path,
                                 const PlayedScene& played, StopSignal* stop = nullptr);

/// The same, and where that is not known so, computed again by the physics.  Throws Error where
/// that is not what was recorded.
SolidsCut CutIn(const std::string& file, const HandPath& path);

/// The session of a recording that is being made, without its way, as soon as that and its scene
/// are there.  None where it ends before, or a signal comes.
/// @param station  as SessionChoice::wanted.
std::optional<HandPath> BegunIn(const std::string& file, const std::string& station,
                                StopSignal& stop);

}  // namespace palpate
