#include "client/replayer/score/performance.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

#include "common/dds/cdr_reader.h"
#include "common/dds/wire.h"
#include "common/error.h"
#include "common/files/bundle_hash.h"
#include "common/recording/recording_reader.h"
#include "scenes/files/effect_file.h"
#include "scenes/files/scene_bundle.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "server/session/servo_loop.h"

namespace palpate {

Performance Perform(const PlayedScene& played, const std::string& tool, const PoseScript& script) {
  const auto& [scene, objects] = played;
  const auto found = std::ranges::find(scene->tools, tool, &Body::name);
  if (found == scene->tools.end()) {
    throw Error("scene '" + scene->name + "' has no tool '" + tool +
                "' that the expert could hold");
  }
  const HapticModel model = MakeModel(*scene, *found, objects);
  ServoLoop loop(model);
  StepWorkspace workspace(model);
  Performance done;
  done.path.station = "expert";
  done.path.scene = scene->name;
  done.path.tool_name = tool;
  done.path.cuts = !loop.cuts().empty();
  if (done.path.cuts) done.cut = {scene, objects, loop.cuts(), {}};
  const auto poses = static_cast<std::uint64_t>(1e3 * script.duration()) + 1;
  for (std::uint64_t i = 0; i < poses; ++i) {
    const double time_s = 1e-3 * static_cast<double>(i);
    const Pose X_WH = script.At(time_s);
    wire::HapticPose pose{};
    pose.pose_sequence = i + 1;
    pose.sample_time_ns = static_cast<std::int64_t>(i + 1) * 1'000'000;
    wire::FromPose(X_WH, pose.position_m, pose.orientation_wxyz);
    // As in a session: the first pose is only checked, forces start with the second.
    if (i == 1) loop.Start(ResolveStart(model, X_WH, workspace).X_WG);
    wire::Wrench answer{};
    loop.OnPose(pose, answer);
    const Wrench wrench = wire::ToWrench(answer);
    done.path.time_s.push_back(time_s);
    done.path.X_WH.push_back(X_WH);
    done.path.X_WG.push_back(
        i == 0 ? X_WH : wire::ToPose(answer.graphic_position_m, answer.graphic_orientation_wxyz));
    done.path.force_N.push_back(wrench.force);
    done.path.torque_Nm.push_back(wrench.torque);
    // Drains the blocks, which would otherwise fill their ring and be held back.
    for (CutBlock block; loop.TakeCut(block);) continue;
  }
  if (done.cut) done.cut->after = std::move(loop.cuts());
  return done;
}

PlayedScene SceneIn(const std::string& recording, const std::string& name) {
  const std::string source = "the scene '" + name + "' of " + recording;
  RecordingReader reader({recording});
  std::map<std::uint64_t, std::vector<std::uint8_t>> bundles;  // by hash
  std::optional<std::uint64_t> wanted;
  for (RecordedSample sample{}; reader.Next(sample);) {
    dds::Owned<wire::SceneBundle> bundle;
    if (!sample.To(bundle.value)) continue;
    const wire::SceneBundle& of = bundle.value;
    if (of.scene == name) wanted = of.hash;
    // A seat's sample has no bytes: the scene's own has them, under the same hash.
    if (of.bundle._length > 0) {
      bundles[of.hash] = {of.bundle._buffer, of.bundle._buffer + of.bundle._length};
    }
    if (!wanted || !bundles.contains(*wanted)) continue;
    CheckBundleHash(bundles.at(*wanted), *wanted, source);
    Scene scene = UnpackScene(bundles.at(*wanted), source);
    LoadEffects(scene.effects, std::filesystem::path(recording).parent_path(), source);
    scene.name = name;
    const auto held = std::make_shared<const Scene>(std::move(scene));
    return {held, MakeObjects(*held)};
  }
  throw Error(recording + ": does not contain its scene '" + name +
              "', which the score needs; record it without --no-bundle");
}

}  // namespace palpate
