#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose.h"

namespace palpate {

/// The motion and forces of a hand in a recorded session, one entry per sample.
struct HandPath {
  std::string station, scene;
  std::uint64_t run = 0;
  bool cuts = false;           ///< the recording holds data about cut solids
  std::vector<double> time_s;  ///< the station's clock, from 0; strictly increasing
  std::vector<Pose> X_WH;
  std::vector<Pose> X_WG;     ///< from the answer to that pose; empty: no pose was answered
  std::vector<Vec3> force_N;  ///< on the hand, from the answer to that pose; 0 if there is none
  std::vector<Vec3> torque_Nm;
  std::string tool_name = {};
  int sessions =
      1;  ///< several: a station that lost its server and came again; nothing between them
  std::vector<bool> answered = {};  ///< whether X_WG and the wrench are known; empty: of all
  double unanswered_share = 0.0;    ///< of the poses during a trial (TrialIn)
  bool cut_off = false;             ///< the recording lacks its end
  std::int64_t begun_ns = 0;        ///< of the recorder's clock, since 1970; 0: it is no recording

  /// The tool's poses: of the graphic tool if known, otherwise the hand's.
  const std::vector<Pose>& tool() const { return X_WG.empty() ? X_WH : X_WG; }
  /// Without contact the wrench is exactly zero (server/physics/solve/README.md).
  bool touches(std::size_t i) const { return !force_N[i].isZero(0.0); }
  std::size_t size() const { return time_s.size(); }
  double duration_s() const { return time_s.empty() ? 0.0 : time_s.back(); }
};

/// Selects a session of a recording.
struct SessionChoice {
  std::string wanted = {};           ///< STATION, or STATION/RUN; empty: there is only one
  const char* option = "--station";  ///< the option that sets it, for messages
  bool joins = false;                ///< the sessions of one station are one path
};

/// Reads the path of one session of the recording, or of all sessions of a station (joins).  Throws
/// Error if there is none, or if there are several to choose from; the message then lists them.
HandPath ReadHandPath(const std::vector<std::string>& files, const SessionChoice& choice = {});

/// Returns the trial within a path, which all measures refer to: from the first move or contact to
/// the last.  The first move is when the hand leaves its initial pose by more than 1 mm or 1
/// degree; the last, when it comes to stay that near to its final pose.  It has only those samples
/// whose answer is known: without one, nobody knows where the tool was.  What an answer says is
/// taken to hold since the one before.
/// @param file  the recording, for the message.  Throws Error if the path has no such part.
HandPath TrialIn(const HandPath& path, const std::string& file);

}  // namespace palpate
