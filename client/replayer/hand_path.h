#pragma once

#include <string>
#include <vector>

#include "common/math/pose.h"

namespace palpate {

/// What a hand did in a recorded session, sample by sample.
struct HandPath {
  std::string station, scene;
  std::vector<double> time_s;  ///< the station's clock, from 0
  std::vector<Pose> X_WH;
  std::vector<Pose> X_WG;     ///< of the answer to that pose; empty: not known
  std::vector<Vec3> force_N;  ///< on the hand, of the answer to that pose; 0 where there is none
  std::vector<Vec3> torque_Nm;

  /// Where the tool was: as objects stopped it, if that is known.
  const std::vector<Pose>& tool() const { return X_WG.empty() ? X_WH : X_WG; }
  std::size_t size() const { return time_s.size(); }
  double duration_s() const { return time_s.empty() ? 0.0 : time_s.back(); }
};

/// The longest session of the recording.  Throws Error where there is none.
HandPath ReadHandPath(const std::vector<std::string>& files);

}  // namespace palpate
