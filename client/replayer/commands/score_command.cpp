#include <optional>

#include <unistd.h>

#include "client/replayer/commands/commands.h"
#include "client/replayer/commands/outcome.h"
#include "common/error.h"
#include "common/program/stop_signal.h"

namespace palpate {
namespace {

constexpr const char* kScoreExamples =
    R"(Examples:
  palpate-replay score expert.mcap try1.mcap try2.mcap try3.mcap \
                 --criteria mine.json --out report
      report/score.html: paths in space, distance, forces, marks, their mean
  palpate-replay score class.mcap class.mcap --expert-station teacher \
                 --station anna
      expert and trainee from one recording; without these options the error
      lists its sessions)";

constexpr int kPolite = 10;

}  // namespace

CommandLine ScoreCommand::AddTo(const CommandLine& app) {
  const CommandLine line =
      app.AddCommand("score", "score a trainee against an expert, per trial and on average");
  line.Footer(kScoreExamples);
  line.Add(
          "expert", score.expert,
          "recording of the expert; or a script of the expert's hand, NAME.path.json, which is run "
          "in the trials' scene")
      .Required();
  line.Add("trials", score.trials,
           "recordings of the trainee; give several, since a single trial predicts little")
      .Required();
  line.Add("--station", score.stations,
           "station of the trainee, if a trial's recording has several sessions; NAME/RUN if the "
           "station has several.  Give it once for all trials, or once per trial")
      .TypeName("NAME")
      .OneAtATime();
  line.Add("--expert-station", score.expert_station, "the same for the expert's recording")
      .TypeName("NAME");
  line.Add("--criteria", score.criteria,
           "file of criteria ('palpate-replay criteria FILE' writes one to edit), or an exercise");
  line.AddFlag("--follow", score.follow,
               "the trial is still being recorded: compute along with it, and score it when the "
               "recording ends, or at Ctrl-C");
  line.AddFlag(
      "--join", score.join,
      "all sessions of one station are one trial, with nothing between them; for a station "
      "that lost its server and connected again");
  line.Add("--person", score.person, "whose trials they are, for the head of the page")
      .TypeName("NAME");
  line.Add("--out", out, "folder for the report: score.html and its figures");
  line.Add("--json", json, "write the score as JSON to this file; -: standard output");
  AddEffectsOption(line);
  return line;
}

void ScoreCommand::Check() const {
  if (score.stations.size() > 1 && score.stations.size() != score.trials.size()) {
    throw UsageError("--station: give it once for all trials, or once per trial");
  }
  if (score.follow && score.trials.size() > 1) {
    throw UsageError("--follow: give only the trial that is being recorded");
  }
}

int ScoreCommand::Run() const {
  std::optional<StopSignal> stop;
  if (score.follow) {
    stop.emplace();
    std::fprintf(stderr, "following %s\n", Printable(score.trials.front()).c_str());
    // While it waits, the class's servo loops must not be disturbed.
    (void)!nice(kPolite);
  }
  ShowReport(MakeReport(score, stop ? &*stop : nullptr), out, json);
  return 0;
}

}  // namespace palpate
