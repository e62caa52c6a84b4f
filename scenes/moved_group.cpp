#include "scenes/moved_group.h"

#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"

namespace palpate {
namespace {

/// The greatest slope of the smooth way from key to key, 3 s^2 - 2 s^3.
constexpr double kSteepest = 1.5;

/// Returns whether two keys are the same place: whole turns apart, but for rounding.
bool AreOnePlace(const MotionKey& a, const MotionKey& b) {
  const double turns = (a.turn - b.turn) / (2.0 * M_PI);
  return std::abs(turns - std::round(turns)) < 1e-9 && (a.shift - b.shift).norm() < 1e-9;
}

}  // namespace

Pose MovedGroup::At(std::int64_t steps) const noexcept {
  if (repeats) steps %= keys.back().at;
  const auto next = std::ranges::find_if(keys, [&](const MotionKey& k) { return k.at > steps; });
  const bool is_last = next == keys.end();
  const MotionKey& to = is_last ? keys.back() : *next;
  const MotionKey& from = is_last ? keys.back() : *(next - 1);
  double s = 0.0;
  if (!is_last) s = static_cast<double>(steps - from.at) / static_cast<double>(to.at - from.at);
  if (smooth) s *= s * (3.0 - 2.0 * s);
  const Quat q = RotationExp((from.turn + s * (to.turn - from.turn)) * axis);
  return {point - q * point + from.shift + s * (to.shift - from.shift), q};
}

std::string MotionFault(const MovedGroup& group) {
  if (group.free) return BodyFault(*group.free);
  const std::vector<MotionKey>& keys = group.keys;
  if (keys.size() < 2) return "has no motion; give at least two keys";
  if (!group.point.allFinite() || !(std::abs(group.axis.norm() - 1.0) < 1e-9)) {
    return "turns about no axis; give a finite point, and a direction";
  }
  const MotionKey& first = keys.front();
  if (first.at != 0 || first.turn != 0.0 || !first.shift.isZero(0.0)) {
    return "does not begin where its objects are placed; give a first key at 0 s, without a turn "
           "or a shift";
  }
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (keys[i].at <= keys[i - 1].at) {
      return "has keys that are not in the order of their times; sort them";
    }
    const auto steps = static_cast<double>(keys[i].at - keys[i - 1].at);
    const double per_s = (group.smooth ? kSteepest : 1.0) * 1e3 / steps;
    const double turn = std::abs(keys[i].turn - keys[i - 1].turn);
    const double shift = (keys[i].shift - keys[i - 1].shift).norm();
    if (!(turn * per_s <= kFastestTurn) || !(shift * per_s <= kFastestShift)) {
      return "goes faster than 1 m/s or 570 deg/s; give its keys more time";
    }
  }
  if (group.repeats && !AreOnePlace(keys.back(), first)) {
    return "repeats, and its last key is not where it begins; end it there, or let it not repeat";
  }
  return "";
}

}  // namespace palpate
