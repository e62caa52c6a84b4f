#pragma once

#include <optional>
#include <string>

#include "client/replayer/hand_path.h"
#include "client/replayer/score/performance.h"
#include "client/replayer/verify/verify.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// Returns what the tool of a recorded session cut, computed from its poses (CutSweep); none if
/// that does not suffice.  Throws Error if the file cannot be read.
/// @param path    the session; its samples are not used.   @param played  its scene.
/// @param stop    null: the recording is complete; otherwise it is being made, and its end, or a
///                signal, is waited for.
std::optional<SolidsCut> SweptIn(const std::string& file, const HandPath& path,
                                 const PlayedScene& played, StopSignal* stop = nullptr);

/// Returns the same result, recomputed by the physics if poses alone do not suffice.  Throws Error
/// if that differs from the recorded wrenches.
SolidsCut CutIn(const std::string& file, const HandPath& path);

/// A session of a recording that is being made, without samples, and its scene.
struct BegunTrial {
  HandPath session;
  PlayedScene played;
};
/// Returns the session whose poses are being recorded, as soon as its scene has been recorded too.
/// Returns none if the recording ends before, or a signal comes.
/// @param station  as SessionChoice::wanted.
std::optional<BegunTrial> BegunIn(const std::string& file, const std::string& station,
                                  StopSignal& stop);

}  // namespace palpate
