#include <cstdio>

#include "client/replayer/commands/commands.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr const char* kStepsExamples =
    R"(Example:
  palpate-replay steps poses.csv --scene cube -o mine.mcap
  palpate-replay --verify mine.mcap
      needs no server and runs as fast as it computes; forces ramp in over the
      first 200 ms, as in a session)";

}  // namespace

CommandLine StepsCommand::AddTo(const CommandLine& app) {
  const CommandLine line =
      app.AddCommand("steps", "step a scene along poses of your own, and record it as a session");
  line.Footer(kStepsExamples);
  line.Add("poses", steps.poses,
           "CSV file, a row a millisecond: x,y,z or x,y,z,qw,qx,qy,qz of the haptic tool, in m")
      .Required();
  line.Add("--scene", steps.scene, "scene, as palpate-server takes it").Required();
  line.Add("--tool", steps.tool, "needed only if the scene has several");
  line.Add("--models", steps.models_dir, "folder of meshes, as with --verify");
  line.Add("-o,--output", steps.file, "recording to write, FILE.mcap").Required();
  AddEffectsOption(line);
  return line;
}

int StepsCommand::Run() const {
  RecordSteps(steps);
  std::printf("%s: verify it with palpate-replay --verify %s\n", Printable(steps.file).c_str(),
              ShellWord(steps.file).c_str());
  return 0;
}

}  // namespace palpate
