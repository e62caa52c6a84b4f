// Makes a golden recording: a hand in contact for a moment, mostly without the scene, whose hash is
// in it.
//   make_golden FOLDER SCENE...        cmake --build --preset release --target golden makes them
//   all
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/json/pose_script.h"
#include "scenes/catalogue.h"
#include "scenes/files/scene_bundle.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "server/session/servo_loop.h"
#include "server/session/world.h"
#include "tests/common/recording/samples.h"

namespace palpate::test {
namespace {

constexpr std::size_t kPoses = 400;  // 200 until the force is full, and 200
constexpr std::uint64_t kRun = 1;
constexpr std::int64_t kTick_ns = 1'000'000;
constexpr std::int64_t kBegan_ns = 1'700'000'000'000'000'000;  // equal inputs, equal files

/// The hands of a recording: of the scene's first tool or, where hands meet, of all tools.
class Golden {
 public:
  Golden(const std::string& scene, const std::string& folder)
      : scene_(LoadScene(scene)), file_(folder + "/" + scene + ".mcap") {
    const auto objects = MakeObjects(scene_);
    for (const Body& tool : scene_.tools) {
      if (!scene_.hands_meet && !models_.empty()) break;
      models_.push_back(std::make_unique<HapticModel>(MakeModel(scene_, tool, objects)));
      scripts_.push_back(PoseScript::Load(ScriptFileBeside(scene, tool.name)));
    }
  }

  void Make() {
    const std::size_t begin =
        scene_.moved.empty() && !scene_.hands_meet ? BusiestMoment() : BusiestStart();
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
    std::size_t contacts = 0;
    Run(begin, [&](std::size_t hand, std::size_t i, const wire::HapticPose& pose,
                   wire::Wrench& wrench, const ServoLoop& loop, const Pose& X_WG) {
      wrench.step_time_s = 0.0;  // which a clock measured
      contacts += wrench.contacts > 0;
      add(dds::PoseTopic(StationOf(hand), kRun), pose, i);
      add(dds::WrenchTopic(StationOf(hand), kRun), wrench, i);
      if (i == 1) AddState(add, hand, loop.start_sequence(), X_WG);
    });
    recording.Close("golden");
    std::printf("%s: %zu poses from %.3f s of its script, %zu in contact, %zu kB\n",
                scene_.name.c_str(), kPoses * models_.size(), 1e-3 * static_cast<double>(begin),
                contacts, std::filesystem::file_size(file_) / 1000);
  }

 private:
  static std::string StationOf(std::size_t hand) {
    return hand == 0 ? "golden" : "golden_" + std::to_string(hand + 1);
  }
  wire::HapticPose At(std::size_t hand, std::size_t begin, std::size_t i) const {
    wire::HapticPose pose{};
    pose.pose_sequence = i + 1;
    pose.sample_time_ns = static_cast<std::int64_t>(i + 1) * kTick_ns;
    wire::FromPose(scripts_[hand].At(1e-3 * static_cast<double>(begin + i)), pose.position_m,
                   pose.orientation_wxyz);
    return pose;
  }

  /// Calls use(hand, i, pose, wrench, loop, start) for each pose of new loops, the hands in turn.
  template <class Use>
  void Run(std::size_t begin, Use use) {
    std::vector<const HapticModel*> models;
    for (const auto& model : models_) models.push_back(model.get());
    const auto world = std::make_shared<World>(models);
    std::vector<std::unique_ptr<ServoLoop>> loops;
    std::vector<Pose> X_WG(models_.size());
    for (std::size_t hand = 0; hand < models_.size(); ++hand) {
      loops.push_back(std::make_unique<ServoLoop>(world, hand));
    }
    for (std::size_t i = 0; i < kPoses; ++i) {
      for (std::size_t hand = 0; hand < models_.size(); ++hand) {
        const wire::HapticPose pose = At(hand, begin, i);
        // As in a session: the first pose is only looked at, the second begins the forces.
        if (i == 1) {
          StepWorkspace workspace(*models_[hand]);
          X_WG[hand] = ResolveStart(*models_[hand], wire::ToPose(pose), workspace).X_WG;
          loops[hand]->Start(X_WG[hand]);
        }
        wire::Wrench wrench{};
        loops[hand]->OnPose(pose, wrench);
        use(hand, i, pose, wrench, *loops[hand], X_WG[hand]);
      }
    }
  }

  /// The time in the script [ms] from which a golden recording has the most poses in contact.
  std::size_t BusiestMoment() {
    ServoLoop loop(*models_.front());
    std::vector<int> touches;
    const auto poses = static_cast<std::size_t>(1e3 * scripts_.front().duration());
    loop.Start(scripts_.front().At(0.0));
    for (std::size_t i = 0; i < poses; ++i) {
      wire::Wrench wrench{};
      loop.OnPose(At(0, 0, i), wrench);
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

  /// Likewise where what comes depends on what was: objects move, or hands meet, which must all
  /// have begun.
  std::size_t BusiestStart() {
    std::size_t best = 0;
    int most = -1;
    for (std::size_t begin = 0;
         1e-3 * static_cast<double>(begin + kPoses) < scripts_.front().duration();
         begin += kPoses / 4) {
      int touches = 0;
      Run(begin, [&](std::size_t, std::size_t i, const wire::HapticPose&, wire::Wrench& wrench,
                     const ServoLoop& loop, const Pose&) {
        touches += wrench.contacts > 0 ? 1 : 0;
        if (i > 1 && loop.start_sequence() == 0) touches = -static_cast<int>(kPoses * kPoses);
      });
      if (touches > most) best = begin;
      most = std::max(most, touches);
    }
    return best;
  }

  void AddScene(const auto& add) {
    std::vector<std::uint8_t> bytes = PackScene(scene_);
    add(dds::kSceneBundleTopic, SampleBundle(bytes, scene_.name, kRun), 0);
  }

  void AddState(const auto& add, std::size_t hand, std::uint64_t start_sequence, const Pose& X_WG) {
    const HapticModel& model = *models_[hand];
    wire::SessionState state{};
    wire::FromText(StationOf(hand), state.station);
    state.run = state.server_run = kRun;
    state.phase = palpate_SESSION_ACTIVE;
    wire::FromText(scene_.name, state.scene);
    wire::FromText(scene_.tools[hand].name, state.tool);
    wire::FromVec3(model.reference(), state.tool_reference_m);
    state.stiffness_N_per_m = model.parameters().stiffness;
    state.torsional_stiffness_Nm_per_rad = model.parameters().torsional_stiffness;
    state.start_sequence = start_sequence;
    wire::FromPose(X_WG, state.start_position_m, state.start_orientation_wxyz);
    add(dds::kSessionStateTopic, state, 1);
  }

  const Scene scene_;
  std::vector<std::unique_ptr<HapticModel>> models_;
  std::vector<PoseScript> scripts_;
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
