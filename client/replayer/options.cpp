#include "client/replayer/options.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <string_view>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "common/dds/topics.h"
#include "common/error.h"
#include "common/program/command_line.h"

namespace palpate {
namespace {

/// At a higher rate, successive targets of a quick hand would lie so far apart that a station would
/// take them for jumps.
constexpr double kMostGuideRate = 2.0;

constexpr const char* kAbout =
    R"(Replays recordings of palpate-record: shows them to viewers as if they were
live, computes them again to verify every bit, or guides another hand along
them.  Also scores a trainee against an expert, and exports recordings as
columns for figures.
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-replay lesson.mcap --rate 0.5 --loop
      shows it to viewers at half speed, repeatedly, until q or Ctrl-C
  palpate-replay lesson.mcap --from 30 --stay
      for a class: waits at the end.  Viewers may pause, seek, change the speed
      and set bookmarks, which are kept in lesson.bookmarks.json beside it
  palpate-replay lesson.mcap --locked
      for an examination: only the keys of this terminal steer it
  palpate-replay lesson.mcap --verify
      computes every wrench again and compares all bits
  palpate-replay 1.mcap --verify --key anatomy/exam-key.pub.pem
      also checks the seal that an exam put on it, 1.seal.json beside it
  palpate-replay expert.mcap --guide trainee
      guides the hand at station 'trainee', which runs with --accept-guide
  palpate-replay score --help
      examples of score; the same for the other commands)";
constexpr const char* kStatus = "Exit status: 0 done, 1 failed or not verified, 2 wrong usage.";

constexpr const char* kExamExamples =
    R"(Example:
  palpate-replay verify-exam anatomy --key anatomy/exam-key.pub.pem --out cert
      verifies all submissions, on all processor cores, and computes their
      points; cert/certificate.html can be printed and signed.  Use a copy of
      the key that was made when the course began, not one that came with the
      folder.  The folder needs the exam's roll, and its exercises unchanged.
Exit status: 0 all verified; 1 something is refused, missing (also the roll)
or changed; 2 wrong usage.)";

constexpr const char* kScoreExamples =
    R"(Examples:
  palpate-replay score expert.mcap try1.mcap try2.mcap try3.mcap \
                 --criteria mine.json --out report
      report/score.html: paths in space, distance, forces, marks, their mean
  palpate-replay score class.mcap class.mcap --expert-station teacher \
                 --station anna
      expert and trainee from one recording; without these options the error
      lists its sessions)";
constexpr const char* kRehearseExamples =
    R"(Example:
  palpate-replay rehearse mine.exercise.json --out report
      needs no server and runs as fast as it computes; report/score.html looks
      as it will for a trial
Exit status: 0 the expert passes; 1 the expert fails, or the exercise has a
mistake; 2 wrong usage.)";
constexpr const char* kStepsExamples =
    R"(Example:
  palpate-replay steps poses.csv --scene cube -o mine.mcap
  palpate-replay --verify mine.mcap
      needs no server and runs as fast as it computes; forces ramp in over the
      first 200 ms, as in a session)";
constexpr const char* kCriteriaExamples =
    R"(Example:
  palpate-replay criteria mine.json
      writes criteria for you to edit: 25 g for periodontal probing, depths of
      sites)";
constexpr const char* kExportExamples =
    R"(Examples:
  palpate-replay export lesson.mcap -o figures
      figures/hand_.../poses.csv and so on, for pandas.read_csv or MATLAB's
      readtable, and METHODS.md
  palpate-replay export lesson.mcap -o arrays --format npy
      for numpy.load
  palpate-replay export lesson.mcap -o cavity --solids --at 20
      what the burs had left after 20 s: cavity/tooth.stl, tooth.ply, and
      caries.palpate, which 'palpate-server ./cavity/caries.palpate' serves)";

/// A command beside the replay itself.
struct Command {
  CommandLine line;
  ReplayOptions::What what{};
  std::function<void()> check = [] {};  ///< takes what was parsed; throws UsageError
};

Command AddScore(const CommandLine& app, ReplayOptions& options) {
  const CommandLine line =
      app.AddCommand("score", "score a trainee against an expert, per trial and on average");
  line.Footer(kScoreExamples);
  line.Add(
          "expert", options.score.expert,
          "recording of the expert; or a script of the expert's hand, NAME.path.json, which is run "
          "in the trials' scene")
      .Required();
  line.Add("trials", options.score.trials,
           "recordings of the trainee; give several, since a single trial predicts little")
      .Required();
  line.Add("--station", options.score.stations,
           "station of the trainee, if a trial's recording has several sessions; NAME/RUN if the "
           "station has several.  Give it once for all trials, or once per trial")
      .TypeName("NAME")
      .OneAtATime();
  line.Add("--expert-station", options.score.expert_station, "the same for the expert's recording")
      .TypeName("NAME");
  line.Add("--criteria", options.score.criteria,
           "file of criteria ('palpate-replay criteria FILE' writes one to edit), or an exercise");
  line.AddFlag("--follow", options.score.follow,
               "the trial is still being recorded: compute along with it, and score it when the "
               "recording ends, or at Ctrl-C");
  line.AddFlag(
      "--join", options.score.join,
      "all sessions of one station are one trial, with nothing between them; for a station "
      "that lost its server and connected again");
  line.Add("--person", options.score.person, "whose trials they are, for the head of the page")
      .TypeName("NAME");
  line.Add("--out", options.out, "folder for the report: score.html and its figures");
  line.Add("--json", options.json, "write the score as JSON to this file; -: standard output");
  AddEffectsOption(line);
  return {line, ReplayOptions::What::kScore, [&score = options.score] {
            if (score.stations.size() > 1 && score.stations.size() != score.trials.size()) {
              throw UsageError("--station: give it once for all trials, or once per trial");
            }
            if (score.follow && score.trials.size() > 1) {
              throw UsageError("--follow: give only the trial that is being recorded");
            }
          }};
}

Command AddVerifyExam(const CommandLine& app, ReplayOptions& options) {
  const CommandLine line =
      app.AddCommand("verify-exam", "verify all submissions of an exam, and write a certificate");
  line.Footer(kExamExamples);
  line.Add("folder", options.sealed.folder, "folder of the course, or a copy of it").Required();
  line.Add("--key", options.sealed.key, "public key of the course, exam-key.pub.pem").Required();
  line.Add("--exam", options.sealed.exam,
           "exam: NAME, or NAME-NUMBER as its roll is named; needed only if there are several");
  line.Add("--models", options.sealed.verify.models_dir, "folder of meshes, as with --verify");
  line.Add("--out", options.out, "folder for the certificate: text, JSON and a page to print");
  line.Add("--json", options.json,
           "write the certificate as JSON to this file; -: standard output");
  AddEffectsOption(line);
  return {line, ReplayOptions::What::kVerifySealed};
}

Command AddRehearse(const CommandLine& app, ReplayOptions& options) {
  const CommandLine line = app.AddCommand(
      "rehearse", "run an exercise with the expert's hand, to see whether it meets the criteria");
  line.Footer(kRehearseExamples);
  line.Add("exercise", options.exercise, "NAME.exercise.json").Required();
  line.Add("--out", options.out, "folder for the report: score.html and its figures");
  line.Add("--json", options.json, "write the score as JSON to this file; -: standard output");
  AddEffectsOption(line);
  return {line, ReplayOptions::What::kRehearse};
}

Command AddCriteria(const CommandLine& app, ReplayOptions& options) {
  const CommandLine line = app.AddCommand("criteria", "write a file of criteria for you to edit");
  line.Footer(kCriteriaExamples);
  line.Add("file", options.new_criteria, "file to write, FILE.json").Required();
  line.Add("--scene", options.criteria_of,
           "scene of the catalogue that burs cut, such as crown; default: criteria for probing");
  return {line, ReplayOptions::What::kCriteria};
}

Command AddExport(const CommandLine& app, ReplayOptions& options) {
  const CommandLine line =
      app.AddCommand("export",
                     "export a recording as columns for figures, or what burs left as meshes\n"
                     "Columns are poses, wrenches, contacts and the limiter's interventions;\n"
                     "METHODS.md has the text for a paper's methods section.");
  line.Footer(kExportExamples);
  line.Add("files", options.columns.files, "a recording, or its split files in order").Required();
  line.Add("-o,--output", options.columns.folder, "folder to create").Required();
  const Option solids_option = line.AddFlag(
      "--solids", options.exports_solids, "export what burs left instead, as STL, PLY and a scene");
  line.AddText(
          "--format",
          [&columns = options.columns](const std::string& text) {
            columns.format = ParseColumnFormat(text);
          },
          "csv, or npy: NumPy arrays with named fields")
      .Excludes(solids_option)
      .ShowDefault("csv");
  line.Add("--at", options.solids.at_s,
           "with --solids: time of the recording, in seconds; default: its end")
      .NotNegative()
      .Needs(solids_option);
  line.Add("--models", options.solids.models_dir,
           "with --solids: folder of meshes, as with --verify")
      .Needs(solids_option);
  return {line, ReplayOptions::What::kExport, [&options] {
            options.solids.files = options.columns.files;
            options.solids.folder = options.columns.folder;
          }};
}

Command AddSteps(const CommandLine& app, ReplayOptions& options) {
  const CommandLine line =
      app.AddCommand("steps", "step a scene along poses of your own, and record it as a session");
  line.Footer(kStepsExamples);
  line.Add("poses", options.steps.poses,
           "CSV file, a row a millisecond: x,y,z or x,y,z,qw,qx,qy,qz of the haptic tool, in m")
      .Required();
  line.Add("--scene", options.steps.scene, "scene, as palpate-server takes it").Required();
  line.Add("--tool", options.steps.tool, "needed only if the scene has several");
  line.Add("--models", options.steps.models_dir, "folder of meshes, as with --verify");
  line.Add("-o,--output", options.steps.file, "recording to write, FILE.mcap").Required();
  AddEffectsOption(line);
  return {line, ReplayOptions::What::kSteps};
}

void AddVerify(const CommandLine& app, ReplayOptions& options, bool& verify) {
  const Option verifies =
      app.AddFlag("--verify", verify, "compute every wrench again and compare all bits");
  app.Add("--scene", options.verify.scene,
          "with --verify: scene to compute with; default: the recorded one, else that of the "
          "catalogue")
      .Needs(verifies);
  app.Add("--models", options.verify.models_dir,
          "with --verify: folder of meshes that no package installs; the environment variable "
          "PALPATE_MODELS has the same effect")
      .Needs(verifies);
  app.Add("--json", options.json,
          "with --verify: write the result as JSON to this file; -: standard output");
  app.Add("--key", options.sealed.key,
          "with --verify: also check the recording's seal with this public key of the course, "
          "exam-key.pub.pem")
      .Needs(verifies);
}

void AddGuide(const CommandLine& app, ReplayOptions& options, bool& no_wait) {
  const Option guide = app.Add("--guide", options.guide.led,
                               "guide the hand at this station along the recorded path")
                           .Excludes(app.Find("--verify"));
  app.AddFlag("--no-wait", no_wait,
              "with --guide: keep the recorded speed even if the hand falls behind")
      .Needs(guide);
  app.Add("--station", options.guide.station,
          "with --guide: station whose path to follow, if the recording has several sessions; "
          "NAME/RUN if the station has several")
      .TypeName("NAME")
      .Needs(guide);
}

void AddPlay(const CommandLine& app, ReplayOptions& options) {
  const Option verify = app.Find("--verify"), guide = app.Find("--guide");
  app.Add("--rate", options.playback.rate,
          "speed relative to the recording; at most 2 with --guide")
      .Range(0.01, 100.0)
      .Excludes(verify)
      .ShowDefault();
  const Option loop =
      app.AddFlag("--loop", options.playback.loop, "repeat until Ctrl-C").Excludes(verify);
  app.AddFlag(
         "--stay", options.play.stays,
         "wait at the end until Ctrl-C, so that viewers can go back; otherwise the replay ends "
         "there unless a viewer has steered it")
      .Excludes(verify)
      .Excludes(guide)
      .Excludes(loop);
  app.AddFlag("--locked", options.play.locked,
              "viewers may watch but not steer: no pause, seek or bookmarks")
      .Excludes(verify)
      .Excludes(guide);
  app.AddFlag("--step", options.play.stepping, "begin paused: space resumes, the right arrow steps")
      .Excludes(verify)
      .Excludes(guide);
  app.Add("--from", options.playback.from_s,
          "begin at this time of the recording, in seconds (with --guide: of the hand's path)")
      .NotNegative()
      .Excludes(verify);
  app.Add("--to", options.playback.to_s, "end at this time, in seconds")
      .Positive()
      .Excludes(verify);
}

/// Takes what was parsed of a replay.  Throws UsageError.
void CheckReplay(const CommandLine& app, ReplayOptions& options) {
  if (options.playback.files.empty()) {
    throw UsageError("a recording is missing; 'palpate-replay --help' shows how");
  }
  const bool verify = app.Find("--verify").given();
  if (verify) options.what = ReplayOptions::What::kVerify;
  if (app.Find("--key").given()) {
    if (options.playback.files.size() != 1) {
      throw UsageError("--key: a sealed recording is a single file; give one file only");
    }
    options.what = ReplayOptions::What::kVerifySealed;
    options.sealed.recording = options.playback.files.front();
    options.sealed.verify = options.verify;
  }
  if (app.Find("--json").given() && !verify)
    throw UsageError("--json needs --verify; add it, or use a command such as score");
  if (!options.guide.led.empty()) {
    options.what = ReplayOptions::What::kGuide;
    if (!dds::IsStationName(options.guide.led)) {
      throw UsageError("--guide '" + options.guide.led +
                       "': give the name of a station, as in its --id");
    }
    if (options.playback.rate > kMostGuideRate) {
      throw UsageError(
          "--rate: a hand is guided at most at twice the recorded speed; give 2 or less");
    }
  }
  if (!(options.playback.to_s > options.playback.from_s)) {
    throw UsageError("--to must be later than --from");
  }
}

}  // namespace

std::optional<ReplayOptions> ParseReplayOptions(int argc, const char* const* argv) {
  ReplayOptions options;
  bool verify = false, no_wait = false;
  const CommandLine app(kAbout, "palpate-replay",
                        std::string(kExamples) + "\n\n" + Keyboard::kHelp + "\n\n" + kStatus);
  app.Add("files", options.playback.files, "a recording, or its split files in order");
  AddVerify(app, options, verify);
  AddGuide(app, options, no_wait);
  AddPlay(app, options);
  AddEffectsOption(app);
  AddNetworkOptions(app, "a viewer or the guided station", options.playback.network);
  AddCommonOptions(app, "number of the domain: the same as that of the viewers and stations",
                   options.playback.domain, options.log_level);
  const Command commands[] = {AddScore(app, options),    AddVerifyExam(app, options),
                              AddRehearse(app, options), AddCriteria(app, options),
                              AddExport(app, options),   AddSteps(app, options)};
  // "verify FILE", like the commands; a recording of that name is ./verify.
  std::vector<const char*> words(argv, argv + argc);
  if (argc > 1 && std::string_view(words[1]) == "verify") words[1] = "--verify";
  if (!ParseCommandLine(app, argc, words.data())) return std::nullopt;
  options.guide.waits = !no_wait;

  const auto given =
      std::ranges::find_if(commands, [](const Command& c) { return c.line.given(); });
  if (given == std::end(commands)) {
    CheckReplay(app, options);
    return options;
  }
  if (!options.playback.files.empty() || verify || app.Find("--guide").given()) {
    throw UsageError(fmt::format(
        "{0} takes no options of a replay; see 'palpate-replay {0} --help'", given->line.name()));
  }
  options.what = given->what;
  given->check();
  return options;
}

}  // namespace palpate
