#include "devices/script_player.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/rotation.h"

namespace palpate {
namespace {

PoseScript WithWayBack(const PoseScript& script) {
  std::vector<PoseScript::Key> keys = script.keys();
  const Pose& first = keys.front().X_WH;
  const Pose& last = keys.back().X_WH;
  const double way = (first.p - last.p).norm();
  const double angle = RotationLog(first.q * last.q.conjugate()).norm();
  // Mean speeds of a calm hand; a minimum-jerk movement peaks at 1.875 times its mean.
  const double seconds = std::max({0.5, way / 0.1, angle / 1.5});
  keys.back().label = "return";
  keys.push_back({keys.back().t + seconds, first, keys.front().label});
  return PoseScript(std::move(keys));
}

}  // namespace

ScriptPlayer::ScriptPlayer(PoseScript script, bool loop)
    : script_(loop ? WithWayBack(script) : std::move(script)), loop_(loop) {}

double ScriptPlayer::Wrap(double t) const noexcept {
  const double duration = script_.duration();
  return loop_ && t > duration ? std::fmod(t, duration) : t;
}

Twist ScriptPlayer::VelocityAt(double t) const noexcept {
  constexpr double kHalf = 0.5e-3;
  const Pose before = At(t - kHalf);
  const Pose after = At(t + kHalf);
  return {(after.p - before.p) / (2.0 * kHalf),
          RotationLog(after.q * before.q.conjugate()) / (2.0 * kHalf)};
}

}  // namespace palpate
