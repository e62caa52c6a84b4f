#include "client/replayer/options.h"

#include <string_view>
#include <vector>

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
      verifies all submissions, on all processor cores; cert/certificate.html
      can be printed.  Use a copy of the key that was made when the course
      began, not one that came with the folder.
Exit status: 0 all verified, 1 something is refused or missing, 2 wrong usage.)";

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

}  // namespace

std::optional<ReplayOptions> ParseReplayOptions(int argc, const char* const* argv) {
  ReplayOptions options;
  bool verify = false;

  const CommandLine app(kAbout, "palpate-replay",
                        std::string(kExamples) + "\n\n" + Keyboard::kHelp + "\n\n" + kStatus);
  app.Add("files", options.playback.files, "a recording, or its split files in order");
  const Option verify_option =
      app.AddFlag("--verify", verify, "compute every wrench again and compare all bits");
  app.Add("--scene", options.verify.scene,
          "with --verify: scene to compute with; default: the recorded one, else that of the "
          "catalogue")
      .Needs(verify_option);
  app.Add("--models", options.verify.models_dir,
          "with --verify: folder of meshes that no package installs; the environment variable "
          "PALPATE_MODELS has the same effect")
      .Needs(verify_option);
  const Option json =
      app.Add("--json", options.json,
              "with --verify: write the result as JSON to this file; -: standard output");
  const Option seal_key =
      app.Add("--key", options.sealed.key,
              "with --verify: also check the recording's seal with this public key of the course, "
              "exam-key.pub.pem")
          .Needs(verify_option);
  const Option guide = app.Add("--guide", options.guide.led,
                               "guide the hand at this station along the recorded path")
                           .Excludes(verify_option);
  bool no_wait = false;
  app.AddFlag("--no-wait", no_wait,
              "with --guide: keep the recorded speed even if the hand falls behind")
      .Needs(guide);
  app.Add("--station", options.guide.station,
          "with --guide: station whose path to follow, if the recording has several sessions; "
          "NAME/RUN if the station has several")
      .TypeName("NAME")
      .Needs(guide);
  app.Add("--rate", options.playback.rate,
          "speed relative to the recording; at most 2 with --guide")
      .Range(0.01, 100.0)
      .Excludes(verify_option)
      .ShowDefault();
  const Option loop =
      app.AddFlag("--loop", options.playback.loop, "repeat until Ctrl-C").Excludes(verify_option);
  app.AddFlag(
         "--stay", options.play.stays,
         "wait at the end until Ctrl-C, so that viewers can go back; otherwise the replay ends "
         "there unless a viewer has steered it")
      .Excludes(verify_option)
      .Excludes(guide)
      .Excludes(loop);
  app.AddFlag("--locked", options.play.locked,
              "viewers may watch but not steer: no pause, seek or bookmarks")
      .Excludes(verify_option)
      .Excludes(guide);
  app.AddFlag("--step", options.play.stepping, "begin paused: space resumes, the right arrow steps")
      .Excludes(verify_option)
      .Excludes(guide);
  app.Add("--from", options.playback.from_s,
          "begin at this time of the recording, in seconds (with --guide: of the hand's path)")
      .NotNegative()
      .Excludes(verify_option);
  app.Add("--to", options.playback.to_s, "end at this time, in seconds")
      .Positive()
      .Excludes(verify_option);
  AddEffectsOption(app);
  AddNetworkOptions(app, "a viewer or the guided station", options.playback.network);
  AddCommonOptions(app, "number of the domain: the same as that of the viewers and stations",
                   options.playback.domain, options.log_level);
  const CommandLine score =
      app.AddCommand("score", "score a trainee against an expert, per trial and on average");
  score.Footer(kScoreExamples);
  score
      .Add(
          "expert", options.score.expert,
          "recording of the expert; or a script of the expert's hand, NAME.path.json, which is run "
          "in the trials' scene")
      .Required();
  score
      .Add("trials", options.score.trials,
           "recordings of the trainee; give several, since a single trial predicts little")
      .Required();
  score
      .Add("--station", options.score.stations,
           "station of the trainee, if a trial's recording has several sessions; NAME/RUN if the "
           "station has several.  Give it once for all trials, or once per trial")
      .TypeName("NAME")
      .OneAtATime();
  score.Add("--expert-station", options.score.expert_station, "the same for the expert's recording")
      .TypeName("NAME");
  score.Add("--criteria", options.score.criteria,
            "file of criteria ('palpate-replay criteria FILE' writes one to edit), or an exercise");
  score.AddFlag("--follow", options.score.follow,
                "the trial is still being recorded: compute along with it, and score it when the "
                "recording ends, or at Ctrl-C");
  score.AddFlag(
      "--join", options.score.join,
      "all sessions of one station are one trial, with nothing between them; for a station "
      "that lost its server and connected again");
  score.Add("--person", options.score.person, "whose trials they are, for the head of the page")
      .TypeName("NAME");
  score.Add("--out", options.out, "folder for the report: score.html and its figures");
  score.Add("--json", options.json, "write the score as JSON to this file; -: standard output");

  const CommandLine exam =
      app.AddCommand("verify-exam", "verify all submissions of an exam, and write a certificate");
  exam.Footer(kExamExamples);
  exam.Add("folder", options.sealed.folder, "folder of the course, or a copy of it").Required();
  exam.Add("--key", options.sealed.key, "public key of the course, exam-key.pub.pem").Required();
  exam.Add("--exam", options.sealed.exam,
           "exam: NAME, or NAME-NUMBER as its roll is named; needed only if there are several");
  exam.Add("--models", options.sealed.verify.models_dir, "folder of meshes, as with --verify");
  exam.Add("--out", options.out, "folder for the certificate: text, JSON and a page to print");
  exam.Add("--json", options.json,
           "write the certificate as JSON to this file; -: standard output");

  const CommandLine rehearse = app.AddCommand(
      "rehearse", "run an exercise with the expert's hand, to see whether it meets the criteria");
  rehearse.Footer(kRehearseExamples);
  rehearse.Add("exercise", options.exercise, "NAME.exercise.json").Required();
  rehearse.Add("--out", options.out, "folder for the report: score.html and its figures");
  rehearse.Add("--json", options.json, "write the score as JSON to this file; -: standard output");

  const CommandLine criteria =
      app.AddCommand("criteria", "write a file of criteria for you to edit");
  criteria.Footer(kCriteriaExamples);
  criteria.Add("file", options.new_criteria, "file to write, FILE.json").Required();
  criteria.Add(
      "--scene", options.criteria_of,
      "scene of the catalogue that burs cut, such as crown; default: criteria for probing");

  std::string format = "csv";
  const CommandLine columns =
      app.AddCommand("export",
                     "export a recording as columns for figures, or what burs left as meshes\n"
                     "Columns are poses, wrenches, contacts and the limiter's interventions;\n"
                     "METHODS.md has the text for a paper's methods section.");
  columns.Footer(kExportExamples);
  columns.Add("files", options.columns.files, "a recording, or its split files in order")
      .Required();
  columns.Add("-o,--output", options.columns.folder, "folder to create").Required();
  bool solids = false;
  const Option solids_option =
      columns.AddFlag("--solids", solids, "export what burs left instead, as STL, PLY and a scene");
  columns.Add("--format", format, "csv, or npy: NumPy arrays with named fields")
      .Excludes(solids_option)
      .ShowDefault();
  columns
      .Add("--at", options.solids.at_s,
           "with --solids: time of the recording, in seconds; default: its end")
      .NotNegative()
      .Needs(solids_option);
  columns
      .Add("--models", options.solids.models_dir,
           "with --solids: folder of meshes, as with --verify")
      .Needs(solids_option);

  const CommandLine steps =
      app.AddCommand("steps", "step a scene along poses of your own, and record it as a session");
  steps.Footer(kStepsExamples);
  steps
      .Add("poses", options.steps.poses,
           "CSV file, a row a millisecond: x,y,z or x,y,z,qw,qx,qy,qz of the haptic tool, in m")
      .Required();
  steps.Add("--scene", options.steps.scene, "scene, as palpate-server takes it").Required();
  steps.Add("--tool", options.steps.tool, "needed only if the scene has several");
  steps.Add("--models", options.steps.models_dir, "folder of meshes, as with --verify");
  steps.Add("-o,--output", options.steps.file, "recording to write, FILE.mcap").Required();

  for (const CommandLine& command : {score, exam, rehearse, steps}) AddEffectsOption(command);
  // "verify FILE", like the commands; a recording of that name is ./verify.
  std::vector<const char*> words(argv, argv + argc);
  if (argc > 1 && std::string_view(words[1]) == "verify") words[1] = "--verify";
  if (!ParseCommandLine(app, argc, words.data())) return std::nullopt;
  options.guide.waits = !no_wait;

  if (columns.given()) {
    if (!options.playback.files.empty() || verify || guide.given()) {
      throw UsageError("export takes no options of a replay; see 'palpate-replay export --help'");
    }
    options.columns.format = ParseColumnFormat(format);
    options.solids.files = options.columns.files;
    options.solids.folder = options.columns.folder;
    options.what = solids ? ReplayOptions::What::kExportSolids : ReplayOptions::What::kExport;
    return options;
  }
  if (steps.given()) {
    if (!options.playback.files.empty() || verify || guide.given()) {
      throw UsageError("steps takes no options of a replay; see 'palpate-replay steps --help'");
    }
    options.what = ReplayOptions::What::kSteps;
    return options;
  }
  if (exam.given()) {
    if (!options.playback.files.empty() || verify || guide.given()) {
      throw UsageError(
          "verify-exam takes no options of a replay; see 'palpate-replay verify-exam --help'");
    }
    options.what = ReplayOptions::What::kVerifySealed;
    return options;
  }
  if (score.given() || criteria.given() || rehearse.given()) {
    if (!options.playback.files.empty() || verify || guide.given()) {
      throw UsageError("score takes no options of a replay; see 'palpate-replay score --help'");
    }
    const std::size_t stations = options.score.stations.size();
    if (stations > 1 && stations != options.score.trials.size()) {
      throw UsageError("--station: give it once for all trials, or once per trial");
    }
    if (options.score.follow && options.score.trials.size() > 1) {
      throw UsageError("--follow: give only the trial that is being recorded");
    }
    options.what = score.given()      ? ReplayOptions::What::kScore
                   : rehearse.given() ? ReplayOptions::What::kRehearse
                                      : ReplayOptions::What::kCriteria;
    return options;
  }
  if (options.playback.files.empty()) {
    throw UsageError("a recording is missing; 'palpate-replay --help' shows how");
  }
  if (verify) options.what = ReplayOptions::What::kVerify;
  if (seal_key.given()) {
    if (options.playback.files.size() != 1) {
      throw UsageError("--key: a sealed recording is a single file; give one file only");
    }
    options.what = ReplayOptions::What::kVerifySealed;
    options.sealed.recording = options.playback.files.front();
    options.sealed.verify = options.verify;
  }
  if (json.given() && !verify)
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
  return options;
}

}  // namespace palpate
