#include <cstdio>

#include "client/replayer/commands/commands.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr const char* kCriteriaExamples =
    R"(Example:
  palpate-replay criteria mine.json
      writes criteria for you to edit: 25 g for periodontal probing, depths of
      sites)";

}  // namespace

CommandLine CriteriaCommand::AddTo(const CommandLine& app) {
  const CommandLine line = app.AddCommand("criteria", "write a file of criteria for you to edit");
  line.Footer(kCriteriaExamples);
  line.Add("file", file, "file to write, FILE.json").Required();
  line.Add("--scene", scene,
           "scene of the catalogue that burs cut, such as crown; default: criteria for probing");
  return line;
}

int CriteriaCommand::Run() const {
  WriteNewCriteria(file, scene);
  std::printf("%s: edit it, then score with: palpate-replay score EXPERT TRIALS --criteria %s\n",
              Printable(file).c_str(), ShellWord(file).c_str());
  return 0;
}

}  // namespace palpate
