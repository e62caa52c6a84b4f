#include "client/replayer/steps/record_steps.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include <spdlog/fmt/fmt.h>

#include "common/dds/cdr_reader.h"
#include "common/dds/topics.h"
#include "common/dds/wire.h"
#include "common/error.h"
#include "common/files/bundle_hash.h"
#include "common/files/whole_file.h"
#include "common/math/pose_check.h"
#include "common/recording/recording_writer.h"
#include "common/text/number_of.h"
#include "scenes/catalogue.h"
#include "scenes/files/scene_bundle.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "server/session/servo_loop.h"

namespace palpate {
namespace {

constexpr std::uint64_t kLargestPoses = std::uint64_t{1} << 30;
constexpr std::int64_t kTick_ns = 1'000'000;
constexpr const char* kStation = "steps";
constexpr std::uint64_t kRun = 1;  // equal inputs, equal files

template <class T>
void Add(RecordingWriter& writer, const std::string& topic, const T& sample, std::int64_t time_ns) {
  std::vector<std::uint8_t> cdr;
  dds::ToCdr(sample, cdr);
  writer.Add(topic, kTypeOf<T>, time_ns, cdr);
}

const Body& ToolOf(const Scene& scene, const std::string& name) {
  if (name.empty() && scene.tools.size() == 1) return scene.tools.front();
  const auto found = std::ranges::find(scene.tools, name, &Body::name);
  if (found != scene.tools.end()) return *found;
  std::string names;
  for (const Body& tool : scene.tools) names += (names.empty() ? "" : ", ") + tool.name;
  throw Error("--tool '" + name + "': scene '" + scene.name + "' has " + names + "; give one");
}

void AddScene(RecordingWriter& writer, const Scene& scene, std::int64_t now_ns) {
  std::vector<std::uint8_t> bytes = PackScene(scene);
  wire::SceneBundle bundle{};
  wire::FromText(scene.name, bundle.scene);
  bundle.server_run = kRun;
  bundle.hash = BundleHash(bytes);
  bundle.bundle._buffer = bytes.data();
  bundle.bundle._length = bundle.bundle._maximum = static_cast<std::uint32_t>(bytes.size());
  Add(writer, dds::kSceneBundleTopic, bundle, now_ns);
}

void AddState(RecordingWriter& writer, const Scene& scene, const Body& tool,
              const HapticModel& model, const Pose& X_WG, std::int64_t now_ns) {
  wire::SessionState state{};
  wire::FromText(kStation, state.station);
  state.run = state.server_run = kRun;
  state.phase = palpate_SESSION_ACTIVE;
  wire::FromText(scene.name, state.scene);
  wire::FromText(tool.name, state.tool);
  wire::FromVec3(model.reference(), state.tool_reference_m);
  state.stiffness_N_per_m = model.parameters().stiffness;
  state.torsional_stiffness_Nm_per_rad = model.parameters().torsional_stiffness;
  state.start_sequence = 1;
  wire::FromPose(X_WG, state.start_position_m, state.start_orientation_wxyz);
  Add(writer, dds::kSessionStateTopic, state, now_ns);
}

}  // namespace

std::vector<Pose> ReadPoses(const std::string& file) {
  std::istringstream lines(ReadWholeFile(file, kLargestPoses));
  std::vector<Pose> poses;
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::erase_if(line, [](unsigned char c) { return std::isspace(c) != 0; });
    if (line.empty()) continue;
    std::vector<double> values;
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) {
      const auto value = NumberOf<double>(cell);
      if (!value) break;
      values.push_back(*value);
    }
    if (values.empty() && poses.empty()) continue;
    if (values.size() != 3 && values.size() != 7) {
      throw Error(fmt::format("{}:{}: has {} numbers; give x,y,z or x,y,z,qw,qx,qy,qz in m", file,
                              number, values.size()));
    }
    Pose& pose = poses.emplace_back();
    pose.p = {values[0], values[1], values[2]};
    if (values.size() == 7) pose.q = Quat(values[3], values[4], values[5], values[6]);
    if (!IsPose(pose)) {
      throw Error(
          fmt::format("{}:{}: is no pose; its numbers must be finite, its quaternion "
                      "w,x,y,z of length 1",
                      file, number));
    }
  }
  if (poses.empty()) throw Error(file + ": has no pose; give a row x,y,z for each millisecond");
  return poses;
}

void RecordSteps(const StepsOptions& options) {
  const std::vector<Pose> poses = ReadPoses(options.poses);
  LoadOptions load;
  load.models_dir = options.models_dir;
  const Scene scene = LoadScene(options.scene, load);
  const Body& tool = ToolOf(scene, options.tool);
  const HapticModel model = MakeModel(scene, tool, MakeObjects(scene));
  const Pose start = [&] {
    StepWorkspace workspace(model);
    return ResolveStart(model, poses.front(), workspace).X_WG;
  }();

  RecordingWriter writer({.file = options.file, .about = {{"made_by", "palpate-replay steps"}}});
  AddScene(writer, scene, kTick_ns);
  AddState(writer, scene, tool, model, start, kTick_ns);
  ServoLoop loop(model);
  loop.Start(start);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::int64_t now_ns = static_cast<std::int64_t>(i + 1) * kTick_ns;
    wire::HapticPose pose{};
    pose.pose_sequence = i + 1;
    pose.sample_time_ns = now_ns;
    wire::FromPose(poses[i], pose.position_m, pose.orientation_wxyz);
    wire::Wrench wrench{};
    loop.OnPose(pose, wrench);
    wrench.step_time_s = 0.0;  // which a clock measured
    Add(writer, dds::PoseTopic(kStation, kRun), pose, now_ns);
    Add(writer, dds::WrenchTopic(kStation, kRun), wrench, now_ns);
    // Otherwise they would fill their ring and be held back.
    for (CutBlock block; loop.TakeCut(block);) continue;
  }
  writer.Close("all poses were stepped");
}

}  // namespace palpate
