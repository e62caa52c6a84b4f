#include "client/replayer/options.h"

#include <CLI/CLI.hpp>

#include "common/dds/topics.h"
#include "common/error.h"
#include "common/program/command_line.h"

namespace palpate {
namespace {

/// Faster, the aims of a quick hand would lie further apart than what a station takes for a leap.
constexpr double kMostGuideRate = 2.0;

constexpr const char* kAbout =
    R"(Replays what palpate-record has recorded: to viewers as if live, through the physics to verify
every bit, or to another hand as a gentle guide; scores a trainee against an expert; and exports it as
columns for a paper's figures.
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-replay lesson.mcap --rate 0.5 --loop
      to viewers, at half the speed, again and again, until q at its terminal or Ctrl-C
  palpate-replay lesson.mcap --from 30 --stay
      for a class: it waits at its end, and whoever watches may pause it, go to any moment, change
      its speed and set bookmarks, which are kept in lesson.bookmarks.json beside it
  palpate-replay lesson.mcap --locked
      for an examination: it is steered by the keys of this terminal alone
  palpate-replay lesson.mcap --verify
      computes every wrench again and compares all bits
  palpate-replay expert.mcap --guide trainee
      leads the hand at station 'trainee', which accepts it with --accept-guide
  palpate-replay score --help
      examples of score; likewise of criteria and export)";
constexpr const char* kStatus = "Exit status: 0 done, 1 failed or not verified, 2 wrong usage.";

constexpr const char* kScoreExamples =
    R"(Examples:
  palpate-replay score expert.mcap try1.mcap try2.mcap try3.mcap --criteria mine.json --out report
      report/score.html: paths in space, distance, forces, marks and their average
  palpate-replay score class.mcap class.mcap --expert-station teacher --station anna
      both of one recording; without these options it says whose sessions there are to choose from)";
constexpr const char* kCriteriaExamples =
    R"(Example:
  palpate-replay criteria mine.json
      writes what to grade by, for you to edit: 25 g for periodontal probing, depths of sites)";
constexpr const char* kExportExamples =
    R"(Examples:
  palpate-replay export lesson.mcap -o figures
      figures/hand_…/poses.csv and so on, for pandas.read_csv or MATLAB's readtable, and METHODS.md
  palpate-replay export lesson.mcap -o figures --format npy
      for numpy.load)";

}  // namespace

std::optional<ReplayOptions> ParseOptions(int argc, const char* const* argv) {
  ReplayOptions options;
  bool verify = false;

  CLI::App app(kAbout, "palpate-replay");
  app.footer(std::string(kExamples) + "\n\n" + Keyboard::kHelp + "\n\n" + kStatus);
  app.add_option("files", options.playback.files, "a recording, or its splits in their order");
  CLI::Option* verify_option =
      app.add_flag("--verify", verify, "compute every wrench again and compare all bits");
  app.add_option("--scene", options.verify.scene,
                 "with --verify: scene to compute with; default: the recorded one, else the "
                 "catalogue's")
      ->needs(verify_option);
  app.add_option("--models", options.verify.models_dir,
                 "with --verify: folder of the meshes that no package installs; the variable "
                 "PALPATE_MODELS does the same")
      ->needs(verify_option);
  CLI::Option* json = app.add_option("--json", options.json,
                                     "with --verify: write the result as JSON; - is stdout");
  CLI::Option* guide = app.add_option("--guide", options.guide.led,
                                      "lead the hand at this station along the recorded path")
                           ->excludes(verify_option);
  app.add_flag_callback(
         "--no-wait", [&options] { options.guide.waits = false; },
         "with --guide: keep the recorded pace even if the hand falls behind")
      ->needs(guide);
  app.add_option(
         "--station", options.guide.station,
         "with --guide: the station whose path to follow, if the recording has several sessions; "
         "NAME/RUN if this station has several")
      ->type_name("NAME")
      ->needs(guide);
  app.add_option("--rate", options.playback.rate,
                 "speed, times the recorded one; at most 2 with --guide")
      ->check(CLI::Range(0.01, 100.0))
      ->excludes(verify_option)
      ->capture_default_str();
  CLI::Option* loop =
      app.add_flag("--loop", options.playback.loop, "repeat until Ctrl-C")->excludes(verify_option);
  app.add_flag(
         "--stay", options.play.stays,
         "wait at the end until Ctrl-C, so that viewers can go back; without it, the replay ends "
         "there unless a viewer has steered it")
      ->excludes(verify_option)
      ->excludes(guide)
      ->excludes(loop);
  app.add_flag("--locked", options.play.locked,
               "viewers may look but not steer: no pause, no seek, no bookmarks")
      ->excludes(verify_option)
      ->excludes(guide);
  app.add_flag("--step", options.play.stepping,
               "begin paused: space goes on, the right arrow steps")
      ->excludes(verify_option)
      ->excludes(guide);
  app.add_option("--from", options.playback.from_s,
                 "begin this many seconds into the recording (with --guide: into the hand's path)")
      ->check(CLI::NonNegativeNumber)
      ->excludes(verify_option);
  app.add_option("--to", options.playback.to_s, "end this many seconds into it")
      ->check(CLI::PositiveNumber)
      ->excludes(verify_option);
  AddNetworkOptions(app, "a viewer or the guided station", options.playback.network);
  AddCommonOptions(app, "domain of viewers and stations: the number that they were given",
                   options.playback.domain, options.log_level);
  CLI::App* score = app.add_subcommand(
      "score", "how near a trainee came to an expert, trial by trial and on average");
  score->footer(kScoreExamples);
  score->add_option("expert", options.score.expert, "recording of the expert")->required();
  score
      ->add_option("trials", options.score.trials,
                   "recordings of the trainee; several, because one predicts nothing")
      ->required();
  score
      ->add_option("--station", options.score.stations,
                   "the trainee, where a trial's recording has several sessions: a station's name; "
                   "NAME/RUN where it has several.  Once for all trials, or once for each")
      ->type_name("NAME")
      ->allow_extra_args(false);
  score
      ->add_option("--expert-station", options.score.expert_station,
                   "the same of the expert's recording")
      ->type_name("NAME");
  score->add_option("--criteria", options.score.criteria,
                    "file to grade by; 'palpate-replay criteria FILE' writes one to begin with");
  score->add_option("--out", options.out, "folder for the report: score.html, and its figures");
  score->add_option("--json", options.json, "write the score as JSON to this file; - is stdout");

  CLI::App* criteria = app.add_subcommand("criteria", "write a file to grade by, for you to edit");
  criteria->footer(kCriteriaExamples);
  criteria->add_option("file", options.new_criteria, "file to write, FILE.json")->required();

  std::string format = "csv";
  CLI::App* columns = app.add_subcommand(
      "export",
      "write poses, wrenches, contacts and the limiter's work as columns, with what a paper's "
      "methods section needs");
  columns->footer(kExportExamples);
  columns->add_option("files", options.columns.files, "a recording, or its splits in their order")
      ->required();
  columns->add_option("-o,--output", options.columns.folder, "folder to make")->required();
  columns->add_option("--format", format, "csv, or npy: arrays of NumPy with named fields")
      ->capture_default_str();
  columns->add_flag("--overwrite", options.columns.overwrite,
                    "replace the folder if it is a former export");

  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  if (*columns) {
    if (!options.playback.files.empty() || verify || *guide) {
      throw UsageError("export takes its recordings alone: 'palpate-replay export --help'");
    }
    options.columns.format = ParseColumnFormat(format);
    options.what = ReplayOptions::What::kExport;
    return options;
  }
  if (*score || *criteria) {
    if (!options.playback.files.empty() || verify || *guide) {
      throw UsageError("score takes its recordings alone: 'palpate-replay score --help'");
    }
    const std::size_t stations = options.score.stations.size();
    if (stations > 1 && stations != options.score.trials.size()) {
      throw UsageError("--station: give it once for all trials, or once for each");
    }
    options.what = *score ? ReplayOptions::What::kScore : ReplayOptions::What::kCriteria;
    return options;
  }
  if (options.playback.files.empty()) {
    throw UsageError("a recording is missing; 'palpate-replay --help' shows how");
  }
  if (verify) options.what = ReplayOptions::What::kVerify;
  if (*json && !verify) throw UsageError("--json goes with --verify or score");
  if (!options.guide.led.empty()) {
    options.what = ReplayOptions::What::kGuide;
    if (!dds::IsStationName(options.guide.led)) {
      throw UsageError("--guide '" + options.guide.led + "': give a station's name, as its --id");
    }
    if (options.playback.rate > kMostGuideRate) {
      throw UsageError("--rate: a hand is led at most at twice the speed; give 2 or less");
    }
  }
  if (!(options.playback.to_s > options.playback.from_s)) {
    throw UsageError("--to must be later than --from");
  }
  return options;
}

}  // namespace palpate
