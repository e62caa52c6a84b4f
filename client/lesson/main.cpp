#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/course/exam.h"
#include "client/course/exercise.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/endpoint.h"
#include "common/dds/random_run.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/program/command_line.h"
#include "common/program/stop_signal.h"
#include "common/realtime/steady_clock.h"
#include "common/text/joined.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPoll{5};
constexpr std::int64_t kPatience_ns = 5'000'000'000;

constexpr const char* kAbout =
    R"(Resets scenes that burs have cut, for all who use them.
'whole' restores them, 'bookmark' saves their state, 'back' returns to it.
Forces are off for a moment, until the tool is clear of the restored material.
'check' checks exercises and exams that a teacher has written.
)";

constexpr const char* kExample =
    R"(Examples:
  palpate-lesson whole calculus
      restores this scene; the page has buttons for it.  A scene file with
      "whole_at_start" restores its scene whenever a session begins and nobody
      else works in it
  palpate-lesson check mine.exercise.json
      reports mistakes by file, line and field, with the remedy.  To write an
      exercise, copy and edit one of those supplied (client/course/exercises or
      /usr/share/palpate/exercises); README.md there explains every field

Exit status: 0 done, 1 failed, 2 wrong usage.)";

struct Options : ServerOptions {
  std::vector<std::string> scenes;
  wire::WholeWish wish = palpate_WHOLE_AGAIN;
  std::vector<std::string> exercises;  ///< to check, without asking a server
};

/// The scenes that a server reports to serve; none before a server is heard.
class Served {
 public:
  explicit Served(const dds::Participant& service)
      : reader_(service, dds::kSceneOfferTopic, dds::Qos::kSession) {}
  ~Served() { dds::FreeContents(offer_); }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  const std::optional<std::vector<std::string>>& Take() {
    dds::CdrSample raw;
    while (reader_.Take(raw, offer_)) {
      names_.emplace();
      for (const wire::OfferedScene& scene :
           std::span(offer_.scenes._buffer, offer_.scenes._length)) {
        names_->push_back(scene.scene);
      }
    }
    return names_;
  }

 private:
  dds::CdrReader<wire::SceneOffer> reader_;
  wire::SceneOffer offer_{};
  std::optional<std::vector<std::string>> names_;
};

void RefuseUnserved(const std::string& scene, const std::vector<std::string>& served) {
  if (std::ranges::find(served, scene) != served.end()) return;
  throw Error("scene '" + scene + "' is not served here; give one of " + Joined(served));
}

std::string Silence(const Options& options, bool heard) {
  const std::string where = "domain " + std::to_string(options.domain) + " of " +
                            (options.network.this_host() ? "this host" : options.network.interface);
  return heard ? "the server in " + where +
                     " does not answer; check that it has the same version as this program"
               : "no server found in " + where +
                     "; start palpate-server, or give its --domain and --network";
}

const char* DoneText(wire::WholeWish wish) {
  switch (wish) {
    case palpate_WHOLE_BOOKMARK:
      return "bookmarked";
    case palpate_WHOLE_BACK:
      return "back at its bookmark";
    default:
      return "whole again";
  }
}

/// Returns 1 if a file has a mistake.
int Check(const std::vector<std::string>& files) {
  bool good = true;
  for (const std::string& file : files) {
    try {
      if (file.ends_with(kExamEnding)) {
        const Exam exam = LoadExam(file);
        std::printf(
            "%s: good: tasks %zu, %.0f s, people %s\n", Printable(file).c_str(), exam.tasks.size(),
            exam.time_s,
            exam.people.empty() ? "all who drive" : std::to_string(exam.people.size()).c_str());
        continue;
      }
      const Exercise exercise = LoadExercise(file);
      std::printf("%s: good: scene %s, tool %s, %.0f s, criteria %zu, trials %d, expert %s\n",
                  Printable(file).c_str(), Printable(exercise.scene).c_str(),
                  Printable(exercise.tool).c_str(), exercise.most_s,
                  exercise.criteria.criteria.size(), exercise.trials,
                  Printable(exercise.expert).c_str());
    } catch (const Error& error) {
      std::fprintf(stderr, "palpate-lesson: %s\n", error.what());
      good = false;
    }
  }
  if (good) std::puts("to see whether the expert passes: palpate-replay rehearse FILE");
  return good ? 0 : 1;
}

/// Returns 1 if the user ended it.
int Run(const Options& options) {
  if (!options.exercises.empty()) return Check(options.exercises);
  StopSignal stop;
  const dds::Participant service = dds::Participant::Service(options.domain, options.network);
  Served served(service);
  dds::Reader<wire::SceneWhole> wholes(service, dds::kSceneWholeTopic, dds::Qos::kRecordSession);
  dds::Writer<wire::WholeRequest> requests(service, dds::kWholeRequestTopic, dds::Qos::kSession);
  std::map<std::uint64_t, std::string> asked;  // not yet answered
  bool any_asked = false;
  for (const std::int64_t began_ns = SteadyNanoseconds();;) {
    const auto& names = served.Take();
    if (names && !any_asked) {
      any_asked = true;
      for (const std::string& scene : options.scenes) RefuseUnserved(scene, *names);
      for (const std::string& scene : options.scenes) {
        wire::WholeRequest request{};
        wire::FromText(scene, request.scene);
        request.request = RandomRun();
        wire::FromText("palpate-lesson", request.by);
        request.wish = options.wish;
        asked[request.request] = scene;
        requests.Write(request);
      }
    }
    for (wire::SceneWhole whole; wholes.Take(whole);) {
      if (asked.erase(whole.request) == 0) continue;
      if (whole.refusal[0] != '\0') {
        throw Error(std::string("scene '") + whole.scene + "': " + whole.refusal);
      }
      std::printf("%s: %s\n", Printable(whole.scene).c_str(), DoneText(whole.wish));
    }
    if (any_asked && asked.empty()) return 0;
    if (SteadyNanoseconds() - began_ns > kPatience_ns) {
      throw Error(Silence(options, names.has_value()));
    }
    if (stop.WaitFor(kPoll)) return 1;
  }
}

/// Returns nothing after --help or --version.  Throws UsageError.
std::optional<Options> ParseOptions(int argc, const char* const* argv) {
  Options options;
  const CommandLine app(kAbout, "palpate-lesson", kExample);
  AddServerOptions(app, options);
  const auto add = [&](const char* name, const char* about, const char* example) {
    const CommandLine command = app.AddCommand(name, about);
    command.Footer(std::string("Example: palpate-lesson ") + example);
    command.Fallthrough();
    command.Add("SCENE", options.scenes, "names of served scenes").Required();
    return command;
  };
  const CommandLine whole =
      add("whole", "restore scenes to their uncut state", "whole calculus periodontal");
  const CommandLine bookmark =
      add("bookmark", "save the state of scenes that burs cut", "bookmark caries");
  const CommandLine back = add("back", "return scenes to their bookmark", "back caries");
  const CommandLine check = app.AddCommand("check", "check the files of exercises and exams");
  check.Footer("Example: palpate-lesson check mine.exercise.json");
  check.Add("FILE", options.exercises, "NAME.exercise.json or NAME.exam.json").Required();
  app.RequireCommands(0, 1);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  if (!whole.given() && !bookmark.given() && !back.given() && !check.given()) {
    throw UsageError(
        "a command is missing; give whole, bookmark, back or check, as in 'palpate-lesson whole "
        "SCENE'");
  }
  if (bookmark.given()) options.wish = palpate_WHOLE_BOOKMARK;
  if (back.given()) options.wish = palpate_WHOLE_BACK;
  for (const std::string& scene : options.scenes) {
    if (scene.size() > 64) throw UsageError("SCENE: the name of a scene has at most 64 characters");
  }
  return options;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-lesson", argc, argv, palpate::ParseOptions, palpate::Run);
}
