#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "scenes/files/scene_bundle.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "server/session/servo_loop.h"
#include "tests/common/recording/samples.h"
#include "tests/support/milliseconds.h"

namespace palpate::test {

/// A session of a scene's first tool, as it is to be recorded.
struct HandRecording {
  std::string station = "hand";
  std::uint64_t run = 9;
  std::uint64_t poses = 0;                                  ///< one a millisecond, the first is 1
  std::function<Pose(std::uint64_t)> at{};                  ///< where the hand is at a pose
  std::function<void(std::uint64_t, wire::Wrench&)> lie{};  ///< falsifies an answer
  std::function<bool(std::uint64_t)> lost{};                ///< poses that are not answered
};

/// Writes the session to a file, replacing what is there.
/// @returns the hash of the scene's bundle.
inline std::uint64_t RecordHand(const Scene& scene, const HapticModel& model,
                                const HandRecording& hand, const std::string& file) {
  RecordingWriter writer({.file = file, .overwrite = true});
  std::vector<std::uint8_t> bytes = PackScene(scene);
  const wire::SceneBundle bundle = SampleBundle(bytes, scene.name);
  Add(writer, dds::kSceneBundleTopic, bundle, kMs);
  ServoLoop loop(model);
  for (std::uint64_t i = 1; i <= hand.poses; ++i) {
    const std::int64_t now_ns = static_cast<std::int64_t>(i + 1) * kMs;
    wire::HapticPose pose{};
    pose.pose_sequence = i;
    pose.sample_time_ns = now_ns;
    wire::FromPose(hand.at(i), pose.position_m, pose.orientation_wxyz);
    if (i == 1) {
      StepWorkspace workspace(model);
      const Pose start = ResolveStart(model, wire::ToPose(pose), workspace).X_WG;
      loop.Start(start);
      wire::SessionState state = SampleState(hand.station, hand.run);
      wire::FromText(scene.name, state.scene);
      wire::FromText(scene.tools.front().name, state.tool);
      state.start_sequence = 1;
      wire::FromPose(start, state.start_position_m, state.start_orientation_wxyz);
      Add(writer, dds::kSessionStateTopic, state, now_ns);
    }
    Add(writer, dds::PoseTopic(hand.station, hand.run), pose, now_ns);
    if (hand.lost && hand.lost(i)) continue;
    wire::Wrench wrench{};
    loop.OnPose(pose, wrench);
    if (hand.lie) hand.lie(i, wrench);
    Add(writer, dds::WrenchTopic(hand.station, hand.run), wrench, now_ns + kMs / 4);
  }
  writer.Close("");
  return bundle.hash;
}

}  // namespace palpate::test
