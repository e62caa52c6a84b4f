#include "client/replayer/options.h"

#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"

namespace palpate {
namespace {

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

}  // namespace

std::optional<ReplayOptions> ParseReplayOptions(int argc, const char* const* argv) {
  ReplayOptions options;
  PlayCommand play;
  VerifyCommand verify;
  GuideCommand guide;
  const CommandLine app(kAbout, "palpate-replay",
                        std::string(kExamples) + "\n\n" + Keyboard::kHelp + "\n\n" + kStatus);
  app.Add("files", play.playback.files, "a recording, or its split files in order");
  verify.AddTo(app);
  guide.AddTo(app);
  play.AddTo(app);
  AddEffectsOption(app);
  AddNetworkOptions(app, "a viewer or the guided station", play.playback.network);
  AddCommonOptions(app, "number of the domain: the same as that of the viewers and stations",
                   play.playback.domain, options.log_level);
  std::tuple<ScoreCommand, VerifyExamCommand, RehearseCommand, CriteriaCommand, ExportCommand,
             StepsCommand>
      commands;
  std::vector<CommandLine> lines;
  std::apply([&](auto&... command) { (lines.push_back(command.AddTo(app)), ...); }, commands);
  // "verify FILE", like the commands; a recording of that name is ./verify.
  std::vector<const char*> words(argv, argv + argc);
  if (argc > 1 && std::string_view(words[1]) == "verify") words[1] = "--verify";
  if (!ParseCommandLine(app, argc, words.data())) return std::nullopt;

  bool is_replay = true;
  const auto take = [&](auto& command, const CommandLine& line) {
    if (!line.given()) return;
    if (!play.playback.files.empty() || verify.given || app.Find("--guide").given()) {
      throw UsageError(fmt::format(
          "{0} takes no options of a replay; see 'palpate-replay {0} --help'", line.name()));
    }
    command.Check();
    options.command = std::move(command);
    is_replay = false;
  };
  auto line = lines.begin();
  std::apply([&](auto&... command) { (take(command, *line++), ...); }, commands);
  if (!is_replay) return options;

  if (play.playback.files.empty()) {
    throw UsageError("a recording is missing; 'palpate-replay --help' shows how");
  }
  verify.files = play.playback.files;
  verify.Check();
  if (!guide.guide.led.empty()) {
    guide.playback = play.playback;
    guide.Check();
  }
  if (!(play.playback.to_s > play.playback.from_s)) {
    throw UsageError("--to must be later than --from");
  }
  if (verify.given) {
    options.command = std::move(verify);
  } else if (!guide.guide.led.empty()) {
    options.command = std::move(guide);
  } else {
    options.command = std::move(play);
  }
  return options;
}

}  // namespace palpate
