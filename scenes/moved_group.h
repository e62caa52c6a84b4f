#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/free_body.h"

namespace palpate {

/// Where a group of objects is after some steps, relative to where they are placed.
struct MotionKey {
  std::int64_t at = 0;        ///< steps since a hand took the tool, which is [ms]
  double turn = 0.0;          ///< about the group's axis [rad]
  Vec3 shift = Vec3::Zero();  ///< after the turn, in W [m]
};

/// A group of objects that moves in W: as a function of the steps (a jaw, a turntable, a conveyor),
/// or as one rigid body that is pushed.
struct MovedGroup {
  std::string name;
  std::optional<FreeBody> free{};                   ///< if it has this, it has no keys
  Vec3 point = Vec3::Zero(), axis = Vec3::UnitZ();  ///< of the turns, in W: [m], unit
  std::vector<MotionKey> keys{};                    ///< by time, the first MotionKey{}
  bool smooth = true;    ///< whether it rests for a moment at each key, or goes at equal speed
  bool repeats = false;  ///< whether the last key, which is where the first is, begins it anew

  /// Returns the group's pose, relative to where its objects are placed.  The same bits everywhere.
  /// Real-time.  Not for a free body.  @param steps  0 or more
  Pose At(std::int64_t steps) const noexcept;
};

inline constexpr std::size_t kMostMoved = 8;  ///< groups of a scene
inline constexpr double kFastestShift = 1.0;  ///< [m/s]
inline constexpr double kFastestTurn = 10.0;  ///< [rad/s]

/// Returns what is wrong with a group's motion, with a remedy; empty: nothing.
std::string MotionFault(const MovedGroup& group);

}  // namespace palpate
