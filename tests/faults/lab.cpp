#include "tests/faults/lab.h"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <thread>

#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "common/error.h"
#include "devices/simulated/phantom_sheets.h"
#include "tests/link/silence.h"
#include "tests/support/web_client.h"

namespace palpate::faults {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

}  // namespace

std::string Seconds(double seconds) {
  return fmt::format("{:.2f} s", seconds);
}

Lab::Lab(int domain, std::string transport)
    : domain_(domain),
      transport_(std::move(transport)),
      folder_(fs::temp_directory_path() / ("palpate_faults_" + std::to_string(getpid()))) {
  fs::remove_all(folder_);
  fs::create_directories(folder_);
}

Lab::~Lab() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

std::unique_ptr<test::Program> Lab::Run(const std::string& name, std::vector<std::string> arguments,
                                        const std::vector<std::string>& before) const {
  arguments.insert(arguments.end(), {"--domain", std::to_string(domain_)});
  arguments.insert(arguments.begin(), test::OwnFolder() + "/" + name);
  if (const auto words = start_with_.find(name); words != start_with_.end()) {
    arguments.insert(arguments.begin(), words->second.begin(), words->second.end());
  }
  arguments.insert(arguments.begin(), before.begin(), before.end());
  const std::string file = arguments.front();
  arguments.erase(arguments.begin());
  return std::make_unique<test::Program>(file, std::move(arguments));
}

namespace {

std::unique_ptr<test::Program> Up(std::unique_ptr<test::Program> program, const std::string& says) {
  if (!program->Says(says, 120.0)) throw Error("does not come up:\n" + program->Output());
  return program;
}

}  // namespace

void Lab::StartServer(const std::vector<std::string>& more,
                      const std::vector<std::string>& before) {
  std::vector<std::string> arguments{"--realtime", "off", "--transport", transport_};
  if (more.empty()) arguments.insert(arguments.end(), {"--scene", "cube"});
  arguments.insert(arguments.end(), more.begin(), more.end());
  server = Up(Run("palpate-server", arguments, before), "ready: ");
}

void Lab::StartStation(const std::vector<std::string>& more) {
  std::vector<std::string> arguments{"--device",
                                     "simulated",
                                     "--id",
                                     "hand",
                                     "--script",
                                     PALPATE_SOURCE_DIR "/tests/link/hold.json",
                                     "--realtime",
                                     "off",
                                     "--transport",
                                     transport_,
                                     "--no-table",
                                     "--trace",
                                     folder_ / "trace.csv"};
  if (more.empty()) arguments.insert(arguments.end(), {"--scene", "cube"});
  arguments.insert(arguments.end(), more.begin(), more.end());
  station = Up(Run("palpate-station", arguments), "session: tool");
}

std::unique_ptr<test::Program> Lab::AnotherStation(const std::string& id,
                                                   const std::string& scene) {
  return Run("palpate-station",
             {"--device", "simulated", "--id", id, "--scene", scene, "--realtime", "off",
              "--transport", transport_, "--no-table", "--loop"});
}

void Lab::StartGateway() {
  gateway = Up(Run("palpate-viewer", {"--http", std::to_string(port_), "--transport", transport_}),
               "ready");
  if (port_ != 0) return;
  gateway->Says("\n");
  const std::string said = gateway->Output();
  const std::size_t at = said.find("http://127.0.0.1:");
  if (at == std::string::npos) throw Error("the gateway names no port:\n" + said);
  port_ = std::atoi(said.c_str() + at + 17);
}

void Lab::StartRecorder() {
  recorder =
      Up(Run("palpate-record", {"-o", recording(), "--transport", transport_}), "recording to ");
}

bool Lab::Answers(double seconds) {
  // The table has a line a second: of two lines, the second is about a time after this call.
  return station->Says(" Hz", seconds) && station->Says(" Hz", seconds) && station->Runs();
}

double Lab::SecondsUntilResumed() {
  const auto begin = Clock::now();
  return station->Says("session resumed", 60.0) ? SecondsSince(begin) : -1.0;
}

std::string Lab::Get(const std::string& path) const {
  const test::HttpAnswer answer = test::Get(port_, path);
  return answer.status == 200 ? answer.body : "";
}

Finding Lab::JudgeTheHand() {
  Finding finding{"no force without a reply, none beyond the slew limit", "", false};
  station->Signal(SIGCONT);
  station->Signal(SIGTERM);
  station->Exit(30.0);
  const std::vector<test::TraceRow> rows = test::ReadTrace(folder_ / "trace.csv");
  const WrenchLimits limits = WrenchLimits::Of(PhantomPremium30().info);
  const double step = test::LargestStep(rows, 0, rows.size(), limits);
  const std::vector<double> silence_ms = test::CountedSilence_ms(rows);
  double late_N = 0.0, most_N = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double force_N = rows[i].applied.force.norm();
    most_N = std::max(most_N, force_N);
    if (silence_ms[i] > test::kForceGone_ms) late_N = std::max(late_N, force_N);
  }
  finding.found = fmt::format(
      "{} ticks, {:.2f} N at most, {:.2f} N after {:.0f} ms of silence, "
      "largest step {:.2f} of the limit",
      rows.size(), most_N, late_N, test::kForceGone_ms, step);
  finding.held = rows.size() > 100 && late_N == 0.0 && step <= 1.0 && most_N > 0.1;
  return finding;
}

void Wait(double seconds) {
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

Finding Lives(const std::string& who, test::Program& program) {
  const bool runs = program.Runs();
  return {who + " lives", runs ? "yes" : "ended:\n" + program.Output(), runs};
}
Finding LoopRuns(Lab& lab) {
  const bool runs = lab.Answers();
  return {"the station's poses are answered", runs ? "yes" : lab.station->Output(), runs};
}
Finding Resumes(Lab& lab) {
  const double seconds = lab.SecondsUntilResumed();
  return {
      "the station resumes untouched once the server is ready (goal 3 s)",
      seconds < 0.0 ? "not within 60 s:\n" + lab.station->Output() : "after " + Seconds(seconds),
      seconds >= 0.0};
}
Finding Undisturbed(Lab& lab, const std::string& said_before) {
  const std::string said = lab.station->Output().substr(said_before.size());
  const bool disturbed = said.find("asking") != std::string::npos ||
                         said.find("no replies") != std::string::npos || !lab.station->Runs();
  return {"the loop goes on", disturbed ? said : "no session was lost", !disturbed};
}
Finding Says(const std::string& must, test::Program& program, const std::string& text) {
  const bool says = program.Says(text, 30.0);
  return {must, says ? "'" + text + "'" : program.Output(), says};
}
Finding EndsInOrder(const std::string& who, test::Program& program) {
  program.Signal(SIGTERM);
  const int exit = program.Exit(30.0);
  return {who + " ends cleanly", fmt::format("exit status {}", exit), exit == 0};
}

Finding Shows(const std::string& must, Lab& lab) {
  Finding shows{must, "", false};
  for (int i = 0; i < 100 && !shows.held; ++i) {
    shows.held = lab.Get("/healthz").find("\"cube\"") != std::string::npos;
    if (!shows.held) Wait(0.1);
  }
  shows.found = shows.held ? "it does" : lab.gateway->Output();
  return shows;
}

}  // namespace palpate::faults
