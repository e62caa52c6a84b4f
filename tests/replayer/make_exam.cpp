// Makes a course whose exam is closed, to measure how long it takes to verify: each person does a
// scene's script again and again, each a little elsewhere.
//   make_exam FOLDER PEOPLE SECONDS [SCENE]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>

#include "client/course/seal.h"
#include "common/files/output.h"
#include "common/json/pose_script.h"
#include "common/text/hex16.h"
#include "scenes/catalogue.h"
#include "scenes/files/scene_bundle.h"
#include "server/physics/scene_model.h"
#include "server/physics/start_pose.h"
#include "server/session/servo_loop.h"
#include "tests/common/recording/samples.h"
#include "tests/support/milliseconds.h"

namespace palpate::test {
namespace {

void Make(const std::string& folder, int people, double seconds, const std::string& name) {
  const Scene scene = LoadScene(name);
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  const PoseScript script = PoseScript::Load(ScriptFileBeside(name));
  const double period = 2.0 * script.duration();
  std::filesystem::create_directories(folder);
  const SealKey key = SealKey::OfCourse(folder);
  for (int person = 1; person <= people; ++person) {
    Seal seal;
    seal.recording = "trials/" + std::to_string(person) + "/" + name + "/1.mcap";
    const std::string file = folder + "/" + seal.recording;
    std::filesystem::create_directories(std::filesystem::path(file).parent_path());
    RecordingWriter writer({.file = file, .overwrite = true});
    std::vector<std::uint8_t> bytes = PackScene(scene);
    const wire::SceneBundle bundle = SampleBundle(bytes, scene.name);
    Add(writer, dds::kSceneBundleTopic, bundle, kMs);
    const auto run = static_cast<std::uint64_t>(person);
    const std::string station = "student" + std::to_string(person);
    const Vec3 elsewhere(2e-5 * person, 0.0, 2e-5 * (person % 7));
    ServoLoop loop(model);
    for (std::uint64_t i = 1; 1e-3 * static_cast<double>(i) <= seconds; ++i) {
      const std::int64_t now_ns = static_cast<std::int64_t>(i + 1) * kMs;
      // There and back, so that nothing leaps.
      const double t = std::fmod(1e-3 * static_cast<double>(i), period);
      Pose X = script.At(std::min(t, period - t));
      X.p += elsewhere;
      wire::HapticPose pose{};
      pose.pose_sequence = i;
      pose.sample_time_ns = now_ns;
      wire::FromPose(X, pose.position_m, pose.orientation_wxyz);
      if (i == 1) {
        StepWorkspace workspace(model);
        const Pose start = ResolveStart(model, X, workspace).X_WG;
        loop.Start(start);
        wire::SessionState state = SampleState(station, run);
        wire::FromText(scene.name, state.scene);
        wire::FromText(scene.tools.front().name, state.tool);
        state.start_sequence = 1;
        wire::FromPose(start, state.start_position_m, state.start_orientation_wxyz);
        Add(writer, dds::kSessionStateTopic, state, now_ns);
      }
      wire::Wrench wrench{};
      loop.OnPose(pose, wrench);
      Add(writer, dds::PoseTopic(station, run), pose, now_ns);
      Add(writer, dds::WrenchTopic(station, run), wrench, now_ns);
    }
    writer.Close("the time is over");
    const HashedFile hashed = Sha256OfFile(file);
    seal.sha256 = hashed.sha256;
    seal.bytes = hashed.bytes;
    seal.person = person;
    seal.name = seal.station = station;
    seal.scene = scene.name;
    seal.scene_hash = Hex16(bundle.hash);
    seal.exam = "synthetic";
    seal.exam_number = seal.task = seal.n = 1;
    seal.exercise = name;
    WriteOutput("seal", folder + "/trials/" + std::to_string(person) + "/" + name + "/1.seal.json",
                SealText(seal, key));
  }
  std::printf("palpate-replay verify-exam %s --key %s/%s\n", folder.c_str(), folder.c_str(),
              SealKey::kPublicFile);
}

}  // namespace
}  // namespace palpate::test

int main(int argc, char** argv) {
  if (argc < 4) {
    std::fprintf(stderr, "usage: make_exam FOLDER PEOPLE SECONDS [SCENE]\n");
    return 2;
  }
  try {
    palpate::test::Make(argv[1], std::atoi(argv[2]), std::atof(argv[3]),
                        argc > 4 ? argv[4] : "periodontal");
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_exam: %s\n", error.what());
    return 1;
  }
}
