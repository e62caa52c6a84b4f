#include "client/replayer/commands/commands.h"
#include "client/replayer/commands/outcome.h"

namespace palpate {
namespace {

constexpr const char* kRehearseExamples =
    R"(Example:
  palpate-replay rehearse mine.exercise.json --out report
      needs no server and runs as fast as it computes; report/score.html looks
      as it will for a trial
Exit status: 0 the expert passes; 1 the expert fails, or the exercise has a
mistake; 2 wrong usage.)";

}  // namespace

CommandLine RehearseCommand::AddTo(const CommandLine& app) {
  const CommandLine line = app.AddCommand(
      "rehearse", "run an exercise with the expert's hand, to see whether it meets the criteria");
  line.Footer(kRehearseExamples);
  line.Add("exercise", exercise, "NAME.exercise.json").Required();
  line.Add("--out", out, "folder for the report: score.html and its figures");
  line.Add("--json", json, "write the score as JSON to this file; -: standard output");
  AddEffectsOption(line);
  return line;
}

int RehearseCommand::Run() const {
  const Report report = Rehearse(LoadExercise(exercise));
  ShowReport(report, out, json);
  return Passed(report) ? 0 : 1;
}

}  // namespace palpate
