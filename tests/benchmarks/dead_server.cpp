// palpate-bench dead-server: what a hand feels when its server dies or stands still, again and
// again, measured from the trace that the real palpate-station writes.
#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "common/error.h"
#include "common/files/project_files.h"
#include "common/realtime/steady_clock.h"
#include "devices/simulated/phantom_sheets.h"
#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/figures.h"
#include "tests/link/silence.h"
#include "tests/support/program.h"
#include "tests/support/roudi.h"

namespace palpate::bench {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kSilent{500};
constexpr milliseconds kPressed{1500};  // the hand comes down, or the force ramps in

struct Options {
  std::string how = "kill";
  std::string transport = "udp";
  int repetitions = 20;
  int domain = 0;
  std::string json;
};

std::unique_ptr<test::Program> StartServer(const Options& options) {
  auto server = std::make_unique<test::Program>(
      test::OwnFolder() + "/palpate-server",
      std::vector<std::string>{"--scene", "cube", "--transport", options.transport, "--domain",
                               std::to_string(options.domain), "--log-level", "warn"});
  if (!server->Says("ready: ", 60.0)) {
    throw Error("dead-server: the server does not start:\n" + server->Output());
  }
  return server;
}

void Await(test::Program& station, const std::string& text) {
  if (!station.Says(text)) throw Error("dead-server: no '" + text + "':\n" + station.Output());
}

/// Silences that one station has seen.  A few: where a hand is inside as its force comes back, the
/// energy is granted, from a budget that is spent after some ten times (EnergyStage::kBudget_J).
constexpr int kMostPerStation = 5;
std::vector<test::Silence> Silences(const Options& options, int count, int done) {
  const std::string trace = std::filesystem::temp_directory_path() /
                            ("palpate-trace-" + std::to_string(getpid()) + ".csv");
  std::unique_ptr<test::Program> server = StartServer(options);
  test::Program station(
      test::OwnFolder() + "/palpate-station",
      {"--device", "simulated", "--scene", "cube", "--id", "bench", "--script",
       PlaceOf(ProjectFile::kHeldHand), "--transport", options.transport, "--domain",
       std::to_string(options.domain), "--no-table", "--trace", trace});
  Await(station, "session: tool");
  std::vector<std::int64_t> silenced_ns;
  for (int i = 0; i < count; ++i) {
    Progress(fmt::format("{} of {} ...", done + i + 1, options.repetitions));
    std::this_thread::sleep_for(kPressed);
    silenced_ns.push_back(SteadyNanoseconds());
    server->Signal(options.how == "freeze" ? SIGSTOP : SIGKILL);
    std::this_thread::sleep_for(kSilent);
    if (options.how == "freeze") {
      server->Signal(SIGCONT);  // its session goes on, or is asked for again
    } else {
      server.reset();
      server = StartServer(options);
      Await(station, "session resumed");
    }
    station.Output();
  }
  std::this_thread::sleep_for(2 * kPressed);
  station.Signal(SIGTERM);
  if (station.Exit() != 0) throw Error("dead-server: the station failed:\n" + station.Output());
  const std::vector<test::TraceRow> rows = test::ReadTrace(trace);
  std::filesystem::remove(trace);
  Progress("");
  const WrenchLimits limits = WrenchLimits::Of(PhantomPremium30().info);
  std::vector<test::Silence> silences;
  for (const std::int64_t time_ns : silenced_ns) {
    silences.push_back(test::MeasureSilence(rows, time_ns, limits));
  }
  return silences;
}

void Run(const Options& options) {
  const std::unique_ptr<RouDi> roudi =
      options.transport == "shm" && !RouDi::AnotherRuns() ? std::make_unique<RouDi>() : nullptr;
  std::vector<double> fall_ms, zero_ms, step, back_ms;
  int stayed_zero = 0;
  for (int done = 0; done < options.repetitions; done += kMostPerStation) {
    const int count = std::min(kMostPerStation, options.repetitions - done);
    for (const test::Silence& silence : Silences(options, count, done)) {
      fall_ms.push_back(silence.until_fall_ms);
      zero_ms.push_back(silence.until_zero_ms);
      step.push_back(silence.largest_step);
      back_ms.push_back(silence.until_back_ms);
      stayed_zero += silence.stayed_zero;
    }
  }
  const Percentiles fall = PercentilesOf(fall_ms), zero = PercentilesOf(zero_ms),
                    steps = PercentilesOf(step), back = PercentilesOf(back_ms);
  Table table(fmt::format("server: {} of {} times over {}; since the first reply that did not come",
                          options.how, options.repetitions, options.transport));
  table.Row("until the force falls", "ms", fall);
  table.Row("until it is zero", "ms", zero);
  table.Row("largest step / slew limit", "", steps);
  table.Row("first reply to whole force", "ms", back);
  table.Line("zero until the next reply",
             fmt::format("{} of {}", stayed_zero, options.repetitions));
  table.Print();
  if (options.json.empty()) return;
  WriteJson(options.json, {{"how", options.how},
                           {"transport", options.transport},
                           {"repetitions", options.repetitions},
                           {"until_fall_ms", ToJson(fall)},
                           {"until_zero_ms", ToJson(zero)},
                           {"step_over_slew_limit", ToJson(steps)},
                           {"until_back_ms", ToJson(back)},
                           {"stayed_zero", stayed_zero}});
}

}  // namespace

void AddDeadServer(const CommandLine& app, const int& domain) {
  auto options = std::make_shared<Options>();
  const CommandLine command = app.AddCommand(
      "dead-server",
      "What a hand feels when palpate-server is killed and started again, or frozen for 0.5 s:\n"
      "how soon its force falls and is gone, and the largest step on the way out and back.\n"
      "Example: palpate-bench dead-server --how freeze --repetitions 20");
  Add(command, "--how", options->how, "kill or freeze").OneOf({"kill", "freeze"});
  AddTransport(command, options->transport);
  Add(command, "--repetitions", options->repetitions).Range(1, 1000);
  AddJson(command, options->json);
  command.Run([options, &domain] {
    options->domain = domain;
    Run(*options);
  });
}

}  // namespace palpate::bench
