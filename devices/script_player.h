#pragma once

#include "common/json/pose_script.h"
#include "common/math/pose.h"

namespace palpate {

/// Plays a PoseScript for a device: once, holding the last pose, or repeatedly.  When it repeats, a
/// movement at hand speed leads from the last pose back to the first, because a hand cannot jump.
class ScriptPlayer {
 public:
  ScriptPlayer(PoseScript script, bool loop);

  /// Returns the pose at time t since the start [s].  Real-time.
  Pose At(double t) const noexcept { return script_.At(Wrap(t)); }
  /// Returns the velocity at t, by central difference over 1 ms, in W.  Real-time.
  Twist VelocityAt(double t) const noexcept;
  const char* LabelAt(double t) const noexcept { return script_.LabelAt(Wrap(t)).c_str(); }

 private:
  double Wrap(double t) const noexcept;

  PoseScript script_;
  bool loop_;
};

}  // namespace palpate
