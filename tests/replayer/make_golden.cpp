// Makes a golden recording: a hand in contact for a moment, mostly without the scene, whose hash is
// in it.
//   make_golden FOLDER SCENE...        cmake --build --preset release --target golden makes them
//   all
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "common/json/pose_script.h"
#include "scenes/catalogue.h"
#include "scenes/files/scene_bundle.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "server/session/servo_loop.h"
#include "tests/common/recording/samples.h"

namespace palpate::test {
namespace {

constexpr std::size_t kPoses = 400;  // 200 until the force is full, and 200
constexpr std::uint64_t kRun = 1;
constexpr const char* kStation = "golden";
constexpr std::int64_t kTick_ns = 1'000'000;
constexpr std::int64_t kBegan_ns = 1'700'000'000'000'000'000;  // equal inputs, equal files

class Golden {
 public:
  Golden(const std::string& scene, const std::string& folder)
      : scene_(LoadScene(scene)),
        model_(MakeModel(scene_, scene_.tools.front(), MakeObjects(scene_))),
        script_(PoseScript::Load(
            std::filesystem::path(FindSceneFile(scene)).replace_extension(".path.json").string())),
        file_(folder + "/" + scene + ".mcap") {}

  void Make() {
    const std::size_t begin = BusiestMoment();
    RecordingOptions options;
    options.file = file_;
    options.bundles = false;
    options.overwrite = true;
    options.about["golden"] = "made by tests/replayer/make_golden.cpp";
    RecordingWriter recording(options);
    const auto add = [&](const std::string& topic, const auto& sample, std::size_t i) {
      std::vector<std::uint8_t> cdr;
      dds::ToCdr(sample, cdr);
      recording.Add(topic, kTypeOf<std::decay_t<decltype(sample)>>,
                    kBegan_ns + static_cast<std::int64_t>(i) * kTick_ns, cdr);
    };
    AddScene(add);

    ServoLoop loop(model_);
    StepWorkspace workspace(model_);
    Pose X_WG;
    std::size_t contacts = 0;
    for (std::size_t i = 0; i < kPoses; ++i) {
      const wire::HapticPose pose = At(begin, i);
      // As in a session: the first pose is only looked at, the second begins the forces.
      if (i == 1) {
        X_WG = ResolveStart(model_, wire::ToPose(pose), workspace).X_WG;
        loop.Start(X_WG);
      }
      wire::Wrench wrench{};
      loop.OnPose(pose, wrench);
      wrench.step_time_s = 0.0;  // which a clock measured
      contacts += wrench.contacts > 0;
      add(dds::PoseTopic(kStation, kRun), pose, i);
      add(dds::WrenchTopic(kStation, kRun), wrench, i);
      if (i == 1) AddState(add, loop.start_sequence(), X_WG);
    }
    recording.Close("golden");
    std::printf("%s: %zu poses from %.3f s of its script, %zu in contact, %zu kB\n",
                scene_.name.c_str(), kPoses, 1e-3 * static_cast<double>(begin), contacts,
                std::filesystem::file_size(file_) / 1000);
  }

 private:
  wire::HapticPose At(std::size_t begin, std::size_t i) const {
    wire::HapticPose pose{};
    pose.pose_sequence = i + 1;
    pose.sample_time_ns = static_cast<std::int64_t>(i + 1) * kTick_ns;
    wire::FromPose(script_.At(1e-3 * static_cast<double>(begin + i)), pose.position_m,
                   pose.orientation_wxyz);
    return pose;
  }

  /// The time in the script [ms] from which a golden recording has the most poses in contact.
  std::size_t BusiestMoment() {
    if (!scene_.moved.empty()) return BusiestStart();
    ServoLoop loop(model_);
    std::vector<int> touches;
    const auto poses = static_cast<std::size_t>(1e3 * script_.duration());
    loop.Start(script_.At(0.0));
    for (std::size_t i = 0; i < poses; ++i) {
      wire::Wrench wrench{};
      loop.OnPose(At(0, i), wrench);
      touches.push_back(static_cast<int>(std::min<std::uint32_t>(wrench.contacts, 6)));
    }
    std::size_t best = 0;
    int sum = 0, most = -1;
    for (std::size_t i = 0; i < touches.size(); ++i) {
      sum += touches[i] - (i >= kPoses ? touches[i - kPoses] : 0);
      if (i + 1 >= kPoses && sum > most) {
        most = sum;
        best = i + 1 - kPoses;
      }
    }
    return best;
  }

  /// Likewise where objects move, which they do from the recording's beginning.
  std::size_t BusiestStart() {
    std::size_t best = 0;
    int most = -1;
    StepWorkspace workspace(model_);
    for (std::size_t begin = 0; 1e-3 * static_cast<double>(begin + kPoses) < script_.duration();
         begin += kPoses / 4) {
      ServoLoop loop(model_);
      loop.Start(ResolveStart(model_, wire::ToPose(At(begin, 0)), workspace).X_WG);
      int touches = 0;
      for (std::size_t i = 0; i < kPoses; ++i) {
        wire::Wrench wrench{};
        loop.OnPose(At(begin, i), wrench);
        touches += wrench.contacts > 0 ? 1 : 0;
      }
      if (touches > most) best = begin;
      most = std::max(most, touches);
    }
    return best;
  }

  void AddScene(const auto& add) {
    std::vector<std::uint8_t> bytes = PackScene(scene_);
    add(dds::kSceneBundleTopic, SampleBundle(bytes, scene_.name, kRun), 0);
  }

  void AddState(const auto& add, std::uint64_t start_sequence, const Pose& X_WG) {
    wire::SessionState state{};
    wire::FromText(kStation, state.station);
    state.run = state.server_run = kRun;
    state.phase = palpate_SESSION_ACTIVE;
    wire::FromText(scene_.name, state.scene);
    wire::FromText(scene_.tools.front().name, state.tool);
    wire::FromVec3(model_.reference(), state.tool_reference_m);
    state.stiffness_N_per_m = model_.parameters().stiffness;
    state.torsional_stiffness_Nm_per_rad = model_.parameters().torsional_stiffness;
    state.start_sequence = start_sequence;
    wire::FromPose(X_WG, state.start_position_m, state.start_orientation_wxyz);
    add(dds::kSessionStateTopic, state, 1);
  }

  const Scene scene_;
  const HapticModel model_;
  const PoseScript script_;
  const std::string file_;
};

}  // namespace
}  // namespace palpate::test

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: make_golden FOLDER SCENE...\n");
    return 2;
  }
  int status = 0;
  for (int i = 2; i < argc; ++i) {
    try {
      palpate::test::Golden(argv[i], argv[1]).Make();
    } catch (const std::exception& error) {
      std::fprintf(stderr, "make_golden: %s: left as it is: %s\n", argv[i], error.what());
      status = 1;
    }
  }
  return status;
}
