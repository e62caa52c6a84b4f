#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose.h"

namespace palpate {

/// What a hand did in a recorded session, sample by sample.
struct HandPath {
  std::string station, scene;
  std::uint64_t run = 0;
  bool cuts = false;           ///< its recording tells of solids that were cut
  std::vector<double> time_s;  ///< the station's clock, from 0; each later than the one before
  std::vector<Pose> X_WH;
  std::vector<Pose> X_WG;     ///< of the answer to that pose; empty: not known
  std::vector<Vec3> force_N;  ///< on the hand, of the answer to that pose; 0 where there is none
  std::vector<Vec3> torque_Nm;
  std::string tool_name = {};

  /// Where the tool was: as objects stopped it, if that is known.
  const std::vector<Pose>& tool() const { return X_WG.empty() ? X_WH : X_WG; }
  /// Without contact the wrench is exactly zero (server/physics/solve/README.md).
  bool touches(std::size_t i) const { return !force_N[i].isZero(0.0); }
  std::size_t size() const { return time_s.size(); }
  double duration_s() const { return time_s.empty() ? 0.0 : time_s.back(); }
};

/// Which session of a recording is meant.
struct SessionChoice {
  std::string wanted = {};           ///< STATION, or STATION/RUN; empty: there is only one
  const char* option = "--station";  ///< that says so
};

/// The path of one session of the recording.  Throws Error where there is none, and, with a list of
/// them, where there are several to choose from.
HandPath ReadHandPath(const std::vector<std::string>& files, const SessionChoice& choice = {});

/// The part of a path that is its trial, and that all measures are of: from the first move or
/// contact to the last.  A hand moves off as it goes more than 1 mm or 1 degree from where it stood
/// at first, and arrives as it comes to stay within that of where it stands at last.
/// @param file  that it is from, for the message.  Throws Error where it has no such part.
HandPath TrialIn(const HandPath& path, const std::string& file);

}  // namespace palpate
