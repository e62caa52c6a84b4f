#include "client/replayer/options.h"

#include "common/dds/topics.h"
#include "common/error.h"
#include "common/program/command_line.h"

namespace palpate {
namespace {

/// At a higher rate, a quick hand's aims would be so far apart that a station takes them for jumps.
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
  palpate-replay 1.mcap --verify --key anatomy/exam-key.pub.pem
      and that it is what was sealed in an exam: its seal 1.seal.json lies beside it
  palpate-replay expert.mcap --guide trainee
      leads the hand at station 'trainee', which accepts it with --accept-guide
  palpate-replay score --help
      examples of score; likewise of criteria and export)";
constexpr const char* kStatus = "Exit status: 0 done, 1 failed or not verified, 2 wrong usage.";

constexpr const char* kExamExamples =
    R"(Example:
  palpate-replay verify-exam anatomy --key anatomy/exam-key.pub.pem --out certificate
      all that was handed in, on all processors; certificate/certificate.html can be printed.  Have
      the key from when the course began, not from whoever gives you the folder.
Exit status: 0 all is verified, 1 something is refused or missing, 2 wrong usage.)";

constexpr const char* kScoreExamples =
    R"(Examples:
  palpate-replay score expert.mcap try1.mcap try2.mcap try3.mcap --criteria mine.json --out report
      report/score.html: paths in space, distance, forces, marks and their average
  palpate-replay score class.mcap class.mcap --expert-station teacher --station anna
      both of one recording; without these options it says whose sessions there are to choose from)";
constexpr const char* kRehearseExamples =
    R"(Example:
  palpate-replay rehearse mine.exercise.json --out report
      as quickly as it computes, with no server; report/score.html shows what a trial's page will.
Exit status: 0 he passes, 1 he does not, or the exercise has a mistake; 2 wrong usage.)";
constexpr const char* kCriteriaExamples =
    R"(Example:
  palpate-replay criteria mine.json
      writes what to grade by, for you to edit: 25 g for periodontal probing, depths of sites)";
constexpr const char* kExportExamples =
    R"(Examples:
  palpate-replay export lesson.mcap -o figures
      figures/hand_…/poses.csv and so on, for pandas.read_csv or MATLAB's readtable, and METHODS.md
  palpate-replay export lesson.mcap -o figures --format npy
      for numpy.load
  palpate-replay export lesson.mcap -o cavity --solids --at 20
      what the burs had left 20 s into it: cavity/tooth.stl, tooth.ply, and caries.palpate, which
      palpate-server ./cavity/caries.palpate serves)";

}  // namespace

std::optional<ReplayOptions> ParseReplayOptions(int argc, const char* const* argv) {
  ReplayOptions options;
  bool verify = false;

  const CommandLine app(kAbout, "palpate-replay",
                        std::string(kExamples) + "\n\n" + Keyboard::kHelp + "\n\n" + kStatus);
  app.Add("files", options.playback.files, "a recording, or its splits in their order");
  const Option verify_option =
      app.AddFlag("--verify", verify, "compute every wrench again and compare all bits");
  app.Add("--scene", options.verify.scene,
          "with --verify: scene to compute with; default: the recorded one, else the catalogue's")
      .Needs(verify_option);
  app.Add("--models", options.verify.models_dir,
          "with --verify: folder of the meshes that no package installs; the variable "
          "PALPATE_MODELS does the same")
      .Needs(verify_option);
  const Option json =
      app.Add("--json", options.json, "with --verify: write the result as JSON; - is stdout");
  const Option seal_key =
      app.Add(
             "--key", options.sealed.key,
             "with --verify: public key of the course that sealed the recording, exam-key.pub.pem; "
             "checks its seal, too")
          .Needs(verify_option);
  const Option guide =
      app.Add("--guide", options.guide.led, "lead the hand at this station along the recorded path")
          .Excludes(verify_option);
  bool no_wait = false;
  app.AddFlag("--no-wait", no_wait,
              "with --guide: keep the recorded pace even if the hand falls behind")
      .Needs(guide);
  app.Add("--station", options.guide.station,
          "with --guide: the station whose path to follow, if the recording has several sessions; "
          "NAME/RUN if this station has several")
      .TypeName("NAME")
      .Needs(guide);
  app.Add("--rate", options.playback.rate, "speed, times the recorded one; at most 2 with --guide")
      .Range(0.01, 100.0)
      .Excludes(verify_option)
      .ShowDefault();
  const Option loop =
      app.AddFlag("--loop", options.playback.loop, "repeat until Ctrl-C").Excludes(verify_option);
  app.AddFlag("--stay", options.play.stays,
              "wait at the end until Ctrl-C, so that viewers can go back; without it, the replay "
              "ends there unless a viewer has steered it")
      .Excludes(verify_option)
      .Excludes(guide)
      .Excludes(loop);
  app.AddFlag("--locked", options.play.locked,
              "viewers may look but not steer: no pause, no seek, no bookmarks")
      .Excludes(verify_option)
      .Excludes(guide);
  app.AddFlag("--step", options.play.stepping, "begin paused: space goes on, the right arrow steps")
      .Excludes(verify_option)
      .Excludes(guide);
  app.Add("--from", options.playback.from_s,
          "begin this many seconds into the recording (with --guide: into the hand's path)")
      .NotNegative()
      .Excludes(verify_option);
  app.Add("--to", options.playback.to_s, "end this many seconds into it")
      .Positive()
      .Excludes(verify_option);
  AddNetworkOptions(app, "a viewer or the guided station", options.playback.network);
  AddCommonOptions(app, "domain of viewers and stations: the number that they were given",
                   options.playback.domain, options.log_level);
  const CommandLine score = app.AddCommand(
      "score", "how near a trainee came to an expert, trial by trial and on average");
  score.Footer(kScoreExamples);
  score
      .Add("expert", options.score.expert,
           "recording of the expert; or his script, NAME.path.json, which is done in the trials' "
           "scene")
      .Required();
  score
      .Add("trials", options.score.trials,
           "recordings of the trainee; several, because one predicts nothing")
      .Required();
  score
      .Add("--station", options.score.stations,
           "the trainee, where a trial's recording has several sessions: a station's name; "
           "NAME/RUN where it has several.  Once for all trials, or once for each")
      .TypeName("NAME")
      .OneAtATime();
  score.Add("--expert-station", options.score.expert_station, "the same of the expert's recording")
      .TypeName("NAME");
  score.Add(
      "--criteria", options.score.criteria,
      "file to grade by: criteria, of which 'palpate-replay criteria FILE' writes some to begin "
      "with, or an exercise");
  score.AddFlag("--follow", options.score.follow,
                "the trial is being recorded: have all ready that can be, and score it as soon as "
                "its recording ends, or at Ctrl-C");
  score.Add("--out", options.out, "folder for the report: score.html, and its figures");
  score.Add("--json", options.json, "write the score as JSON to this file; - is stdout");

  const CommandLine exam = app.AddCommand(
      "verify-exam", "verify all that was handed in in an exam, and write a certificate");
  exam.Footer(kExamExamples);
  exam.Add("folder", options.sealed.folder, "of the course, or a copy of it").Required();
  exam.Add("--key", options.sealed.key, "the course's public key, exam-key.pub.pem").Required();
  exam.Add("--exam", options.sealed.exam,
           "NAME, or NAME-NUMBER as its roll is named; may be left out where there is one");
  exam.Add("--models", options.sealed.verify.models_dir, "as with --verify");
  exam.Add("--out", options.out, "folder for the certificate: text, JSON, and a page to print");
  exam.Add("--json", options.json, "write it as JSON to this file; - is stdout");

  const CommandLine rehearse = app.AddCommand(
      "rehearse", "let the expert's hand do an exercise, and grade it: can its criteria be met?");
  rehearse.Footer(kRehearseExamples);
  rehearse.Add("exercise", options.exercise, "NAME.exercise.json").Required();
  rehearse.Add("--out", options.out, "folder for the report: score.html, and its figures");
  rehearse.Add("--json", options.json, "write the score as JSON to this file; - is stdout");

  const CommandLine criteria =
      app.AddCommand("criteria", "write a file to grade by, for you to edit");
  criteria.Footer(kCriteriaExamples);
  criteria.Add("file", options.new_criteria, "file to write, FILE.json").Required();
  criteria.Add("--scene", options.criteria_of,
               "for this scene of the catalogue that burs cut, as crown; default: for probing");

  std::string format = "csv";
  const CommandLine columns = app.AddCommand(
      "export",
      "write poses, wrenches, contacts and the limiter's work as columns, with what a paper's "
      "methods section needs; or what burs left, as meshes and as a scene");
  columns.Footer(kExportExamples);
  columns.Add("files", options.columns.files, "a recording, or its splits in their order")
      .Required();
  columns.Add("-o,--output", options.columns.folder, "folder to make").Required();
  bool solids = false;
  const Option solids_option =
      columns.AddFlag("--solids", solids,
                      "in place of columns: what burs left, as STL, PLY and a scene that loads");
  columns.Add("--format", format, "csv, or npy: arrays of NumPy with named fields")
      .Excludes(solids_option)
      .ShowDefault();
  columns
      .Add("--at", options.solids.at_s,
           "with --solids: what was left so many seconds into the recording; default: at its end")
      .NotNegative()
      .Needs(solids_option);
  columns.Add("--models", options.solids.models_dir, "with --solids: as with --verify")
      .Needs(solids_option);

  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  options.guide.waits = !no_wait;

  if (columns.given()) {
    if (!options.playback.files.empty() || verify || guide.given()) {
      throw UsageError("export takes its recordings alone: 'palpate-replay export --help'");
    }
    options.columns.format = ParseColumnFormat(format);
    options.solids.files = options.columns.files;
    options.solids.folder = options.columns.folder;
    options.what = solids ? ReplayOptions::What::kExportSolids : ReplayOptions::What::kExport;
    return options;
  }
  if (exam.given()) {
    if (!options.playback.files.empty() || verify || guide.given()) {
      throw UsageError("verify-exam takes a folder alone: 'palpate-replay verify-exam --help'");
    }
    options.what = ReplayOptions::What::kVerifySealed;
    return options;
  }
  if (score.given() || criteria.given() || rehearse.given()) {
    if (!options.playback.files.empty() || verify || guide.given()) {
      throw UsageError("score takes its recordings alone: 'palpate-replay score --help'");
    }
    const std::size_t stations = options.score.stations.size();
    if (stations > 1 && stations != options.score.trials.size()) {
      throw UsageError("--station: give it once for all trials, or once for each");
    }
    if (options.score.follow && options.score.trials.size() > 1) {
      throw UsageError("--follow: one trial is recorded at a time; give that one");
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
      throw UsageError("--key: a sealed recording is one file; give it alone");
    }
    options.what = ReplayOptions::What::kVerifySealed;
    options.sealed.recording = options.playback.files.front();
    options.sealed.verify = options.verify;
  }
  if (json.given() && !verify) throw UsageError("--json goes with --verify or score");
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
