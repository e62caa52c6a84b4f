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
#include "tests/replayer/hand_recording.h"

namespace palpate::test {
namespace {

void Make(const std::string& folder, int people, double seconds, const std::string& name) {
  const Scene scene = LoadScene(name);
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  const PoseScript script = PoseScript::Load(ScriptFileBeside(name));
  const double period = 2.0 * script.duration();
  std::filesystem::create_directories(folder);
  const SealKey key = SealKey::OfCourse(folder);
  const std::string exam_file = folder + "/synthetic" + kExamEnding;
  WriteOutput("exam", exam_file,
              R"({"title": "Synthetic", "time_s": 3600, "tasks": [{"exercise": "light-force"}]})");
  const Exam exam = LoadExam(exam_file);
  Roll roll;
  roll.exam = exam.name;
  roll.exam_number = 1;
  roll.exam_sha256 = exam.sha256;
  roll.tasks = exam.tasks;
  roll.complete = true;
  for (int person = 1; person <= people; ++person) {
    Seal seal;
    seal.recording = "trials/" + std::to_string(person) + "/" + name + "/1.mcap";
    const std::string file = folder + "/" + seal.recording;
    std::filesystem::create_directories(std::filesystem::path(file).parent_path());
    const std::string station = "student" + std::to_string(person);
    const Vec3 elsewhere(2e-5 * person, 0.0, 2e-5 * (person % 7));
    const auto at = [&](std::uint64_t i) {
      // There and back, so that the hand never leaps.
      const double t = std::fmod(1e-3 * static_cast<double>(i), period);
      Pose X = script.At(std::min(t, period - t));
      X.p += elsewhere;
      return X;
    };
    const std::uint64_t hash = RecordHand(scene, model,
                                          {station, static_cast<std::uint64_t>(person),
                                           static_cast<std::uint64_t>(1e3 * seconds), at},
                                          file);
    const HashedFile hashed = Sha256OfFile(file);
    seal.sha256 = hashed.sha256;
    seal.bytes = hashed.bytes;
    seal.person = person;
    seal.name = seal.station = station;
    seal.scene = scene.name;
    seal.scene_hash = Hex16(hash);
    seal.exam = exam.name;
    seal.exam_number = seal.task = seal.n = 1;
    seal.exercise = exam.tasks.front().exercise;
    seal.previous = roll.last;
    const std::string text = SealText(seal, key);
    WriteOutput("seal", folder + "/trials/" + std::to_string(person) + "/" + name + "/1.seal.json",
                text);
    roll.last = Sha256(text);
    Roll::Entry entry;
    entry.person = person;
    entry.seal = roll.last;
    roll.trials.push_back(entry);
  }
  std::filesystem::create_directories(folder + "/exams");
  WriteOutput("roll", folder + "/exams/synthetic-1" + kRollEnding, SealText(roll, key));
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
