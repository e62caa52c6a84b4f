#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/dds/wire.h"
#include "server/session/session.h"
#include "tests/support/test_trees.h"

namespace palpate::test {

inline constexpr std::int64_t kMs = 1'000'000;
inline constexpr std::uint64_t kServerRun = 99;
inline constexpr double kBallRadius = 0.050;
inline constexpr double kToolRadius = 0.005;
/// Height of the tool's centre when it touches the ball from above [m].
inline constexpr double kTouch = kBallRadius + kToolRadius;
inline constexpr double kStiffness = 1000.0;

/// A ball of radius 50 mm at the origin, felt with one of 5 mm: pressed straight down to height z,
/// the hand feels kStiffness * (kTouch - z) upward.
/// @param p_TC  the probe's centre in the tool's frame.
inline std::shared_ptr<const ServedTool> BallTool(const std::string& scene = "ball",
                                                  const std::string& tool = "probe",
                                                  const Vec3& p_TC = Vec3::Zero()) {
  const Ball ball{Vec3::Zero(), kBallRadius};
  const Ball probe{p_TC, kToolRadius};
  const SphereTree object = MakeTree({&ball, 1});
  const PlacedTree placed{&object, Pose{}};
  StepParameters parameters;
  parameters.stiffness = kStiffness;
  return std::make_shared<const ServedTool>(ServedTool{
      scene, tool,
      HapticModel(MakeTree({&probe, 1}),
                  std::make_shared<const SceneObjects>(std::span(&placed, 1)), parameters)});
}

/// Makes a station's poses, one a millisecond.
class Hand {
 public:
  /// Above the ball's centre, at height `z`.
  wire::HapticPose At(double z) { return At(Vec3(0, 0, z)); }
  wire::HapticPose At(const Vec3& p) {
    wire::HapticPose pose{};
    pose.pose_sequence = ++sequence;
    pose.sample_time_ns = 1'000'000 * static_cast<std::int64_t>(sequence);
    wire::FromPose({p, Quat::Identity()}, pose.position_m, pose.orientation_wxyz);
    return pose;
  }
  std::uint64_t sequence = 0;
};

}  // namespace palpate::test
