#pragma once

#include "common/json/pose_script.h"
#include "common/math/pose.h"

namespace palpate {

/// A PoseScript in the hands of a device: played once and held at its end, or again and again. When
/// it repeats, a movement at hand speed leads from the last pose back to the first, because a jump
/// is not something that a hand can do.
class ScriptPlayer {
 public:
  ScriptPlayer(PoseScript script, bool loop);

  /// Real-time.  @param t  since the start [s].
  Pose At(double t) const noexcept { return script_.At(Wrap(t)); }
  /// Velocity at t, by central difference over 1 ms, both in W.  Real-time.
  Twist VelocityAt(double t) const noexcept;
  const char* LabelAt(double t) const noexcept { return script_.LabelAt(Wrap(t)).c_str(); }

 private:
  double Wrap(double t) const noexcept;

  PoseScript script_;
  bool loop_;
};

}  // namespace palpate
