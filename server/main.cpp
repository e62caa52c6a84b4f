#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <malloc.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "common/dds/server_lock.h"
#include "common/error.h"
#include "common/metrics/metrics_port.h"
#include "common/program/command_line.h"
#include "common/program/log.h"
#include "common/program/realtime.h"
#include "common/program/stop_signal.h"
#include "common/realtime/steady_clock.h"
#include "common/revision.h"
#include "scenes/catalogue.h"
#include "scenes/files/mesh_options.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/files/scene_file.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/progress_line.h"
#include "scenes/scene_verdict.h"
#include "server/observation/event_log.h"
#include "server/observation/server_metrics.h"
#include "server/offer/served_scene.h"
#include "server/transport/compile_news.h"
#include "server/transport/server.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPoll{5};
/// A session's buffers are larger than this, tens of megabytes in all.
constexpr int kOwnMapping_bytes = 1 << 20;

constexpr const char* kAbout =
    R"(Serves scenes to haptic stations.  A station sends the pose of the hand; the
server answers with the force and torque on the tool.  Prints a line that begins
with 'ready' once stations can connect, then a line of statistics per station
and second.
)";

constexpr const char* kExample =
    R"(Examples:
  palpate-server --scene bunny-bunny
      then, in another terminal:
      palpate-station --device simulated --scene bunny-bunny --id left
  palpate-server tooth.stl
      a mesh of your own, with a ball as the tool; then either
      palpate-viewer --http 8765
          and drag the ball with the mouse on the page, or
      palpate-station --device simulated --scene tooth.stl --id left
          for a simulated hand)";

struct Options {
  std::vector<std::string> scenes;
  int seats = 0;  // of each scene
  std::string transport = "auto";
  dds::Network network;
  RealtimeOptions realtime;
  std::string models;
  MeshSceneOptions mesh;
  bool unusable_too = false;
  bool admit_by_hand = false;
  std::uint64_t hand_seed = 1;
  std::optional<MetricsEndpoint> metrics;
  std::vector<std::string> host_names;  // under which metrics may be requested
  std::string event_log;
  int domain = 0;
  std::string log_level = "info";
};

/// Logs what `palpate-scene check` says of a scene.  Refuses an unusable one unless `unusable_too`.
void Judge(const std::string& name, const Scene& scene, bool unusable_too) {
  const Verdict verdict = JudgeScene(scene);
  for (const std::string& limit : verdict.limits) spdlog::warn("{}: {}", scene.name, limit);
  for (const std::string& fault : verdict.faults) {
    if (!unusable_too) {
      throw Error(name + ": is not usable: " + fault +
                  " ('palpate-scene check' gives details; --unusable-too serves it nevertheless)");
    }
    spdlog::warn("{}: not usable: {}", scene.name, fault);
  }
}

/// Adds a scene and its seats, which share its models: NAME, NAME-1, NAME-2, ...
void AddToOffer(ServedScene scene, int seats, std::vector<ServedScene>& offer,
                std::vector<std::shared_ptr<const ServedTool>>& tools,
                std::vector<std::string>& seat_names) {
  for (int number = 0; number <= seats; ++number) {
    const std::string name = number == 0 ? scene.name : fmt::format("{}-{}", scene.name, number);
    if (std::ranges::find(offer, name, &ServedScene::name) != offer.end()) {
      throw UsageError("--scene " + name +
                       ": a seat of another scene already has this name; give fewer --seats, or "
                       "rename the file");
    }
    if (number > 0) seat_names.push_back(name);
    offer.push_back(number == 0 ? scene : SeatOf(scene, name));
    for (const ServedScene::Tool& tool : offer.back().tools) tools.push_back(tool.served);
  }
}

/// The records of a server for those who run it, where requested: metrics and events.
class Record {
 public:
  Record(const Options& options, const dds::TransportChoice& transport,
         const RealtimeReport& realtime)
      : start_{{"version", PALPATE_VERSION},
               {"physics", kPhysicsRevision},
               {"domain", std::to_string(options.domain)},
               {"transport", transport.reason},
               {"realtime", realtime.summary}},
        metrics_(transport, realtime) {
    if (!options.event_log.empty()) events_ = std::make_unique<EventLog>(options.event_log);
    if (!options.metrics) return;
    port_ = std::make_unique<MetricsPort>(
        MetricsPort::Options{.endpoint = *options.metrics, .host_names = options.host_names},
        [this](MetricsPage& page) { metrics_.Fill(page); });
    spdlog::info("metrics: {}", port_->url());
  }

  void Follow(Server& server) {
    server.Observe({.session =
                        [this](const wire::SessionState& state) {
                          metrics_.OnSession(state);
                          if (events_) events_->OnSession(state, SteadyNanoseconds());
                        },
                    .untold =
                        [this](std::uint64_t count) {
                          metrics_.OnUntold(count);
                          if (events_) events_->OnUntold(count);
                        },
                    .whole =
                        [this](const wire::SceneWhole& whole) {
                          metrics_.OnWhole(whole);
                          if (events_) events_->OnWhole(whole, SteadyNanoseconds());
                        },
                    .statistics =
                        [this](const wire::LoopStatistics& statistics) {
                          metrics_.OnStatistics(statistics);
                          if (events_) events_->OnStatistics(statistics, SteadyNanoseconds());
                        }});
  }

  void Start(const std::string& scenes) {
    start_.emplace_back("scenes", scenes);
    if (events_) events_->OnStart(start_);
  }

 private:
  EventLog::Fields start_;
  ServerMetrics metrics_;
  std::unique_ptr<EventLog> events_;
  std::unique_ptr<MetricsPort> port_;  // its thread reads metrics_
};

/// Prints a line if somebody reads: a full pipe or a terminal that was stopped takes none, and the
/// sessions must not wait for it.
void SayIfRead(const std::string& line) {
  pollfd out{STDOUT_FILENO, POLLOUT, 0};
  if (poll(&out, 1, 0) == 0) return;
  std::puts(line.c_str());
  std::fflush(stdout);
}

int Serve(const Options& options) {
  StopSignal stop;
  // By default malloc takes them from its heap once the first session has ended, and
  // they stay there: with four stations that came and went, the server grew from 161 to
  // 228 MB in seven minutes.
  mallopt(M_MMAP_THRESHOLD, kOwnMapping_bytes);
  const ServerLock lock(options.domain);
  const dds::TransportChoice transport =
      dds::ChooseTransport(dds::ParseTransport(options.transport), options.network);

  // The receiving threads, which are the servo loops, inherit what this thread has at this moment.
  const RealtimeReport realtime = EnterRealtime(options.realtime);
  dds::Participant loop_domain = dds::Participant::Loop(options.domain, transport, options.network);
  LeaveRealtime();

  // Before scenes are built, so that errors are reported at once and viewers hear what is built.
  Record record(options, transport, realtime);
  dds::Participant service_domain = dds::Participant::Service(options.domain, options.network);
  std::optional<CompileNews> news(service_domain);

  LoadOptions load;
  load.models_dir = options.models;
  load.mesh = options.mesh;
  load.tell = [](const std::string& text) { spdlog::info("{}", text); };
  load.warn = [](const std::string& text) { spdlog::warn("{}", text); };
  std::vector<std::shared_ptr<const ServedTool>> tools;
  std::vector<ServedScene> offer;
  std::map<std::string, std::vector<std::uint8_t>> bundles;
  std::map<std::string, std::vector<std::string>> seats;  // of each scene
  std::string names;
  for (const std::string& name : options.scenes) {
    ProgressLog log([&](const std::string& text) { spdlog::info("{}: {}", name, text); });
    load.progress = [&](std::string_view stage, double done) {
      log(stage, done);
      news->Tell(SceneNameOf(name), stage, done, SteadyNanoseconds());
    };
    const Scene scene = LoadScene(name, load);
    Judge(name, scene, options.unusable_too);
    if (bundles.contains(scene.name)) {
      throw UsageError(
          "--scene " + name + ": '" + scene.name +
          "' is already served, and stations know scenes only by name; give it once, or rename one "
          "of the files");
    }
    AddToOffer(ServeScene(scene, name, options.hand_seed), options.seats, offer, tools,
               seats[scene.name]);
    bundles[scene.name] = PackScene(scene);
    names += (names.empty() ? "" : ", ") + scene.name;
    if (options.seats > 0) names += fmt::format(" (seats: {})", options.seats);
  }
  news.reset();
  malloc_trim(0);  // the models' sources took as much memory again

  Server server(std::move(loop_domain), std::move(service_domain), std::move(tools), SayIfRead,
                options.admit_by_hand);
  record.Follow(server);
  for (auto& [name, bundle] : bundles) server.PublishScene(name, std::move(bundle), seats[name]);
  server.Offer(offer);
  SayIfRead(fmt::format("ready: scenes {}; transport {}; real-time {}; domain {}", names,
                        transport.reason, realtime.summary, options.domain));
  record.Start(names);
  do {
    server.Poll(SteadyNanoseconds());
  } while (!stop.WaitFor(kPoll));
  return 0;
}

/// Returns nothing for --help and --version.  Throws UsageError.
std::optional<Options> ParseOptions(int argc, const char* const* argv) {
  Options options;
  const CommandLine app(kAbout, "palpate-server");
  app.Footer(kExample);
  app.Add("SCENE,--scene", options.scenes,
          "scenes to serve: names from the catalogue, scene files, or meshes (STL, OBJ, PLY, "
          "3DS, glTF).  A mesh becomes a scene with a ball as the tool")
      .Required();
  app.Add("--seats", options.seats,
          "number of further copies of each scene, named NAME-1, NAME-2, ...  They share one model "
          "in memory; cuts in one copy do not appear in the others")
      .Range(0, static_cast<int>(SessionTable::kMaxStations));
  AddMeshOptions(app, options.mesh);
  app.Add("--transport", options.transport,
          "transport of poses and wrenches.  auto: shared memory if RouDi answers, else UDP; shm, "
          "udp: this one only")
      .ShowDefault();
  AddRealtimeOptions(app, "the servo loop", options.realtime);
  app.Add("--models", options.models,
          "folder of meshes that no package installs; the environment variable PALPATE_MODELS "
          "has the same effect");
  AddEffectsOption(app);
  app.AddFlag("--unusable-too", options.unusable_too,
              "serve scenes even if 'palpate-scene check' finds them unusable; prints a warning");
  app.AddFlag(
      "--admit-by-hand", options.admit_by_hand,
      "each station waits until a person with the role 'operate' admits it on the web page");
  app.Add("--hand-seed", options.hand_seed,
          "seed of the generated hand path of a scene without a script (NAME.path.json)")
      .ShowDefault();
  app.AddText(
         "--metrics",
         [&options](const std::string& text) { options.metrics = ParseMetricsEndpoint(text); },
         "serve Prometheus metrics at http://ADDRESS:PORT/metrics; put an IPv6 address in "
         "brackets.  Without ADDRESS: for this host only.  Default: no metrics")
      .TypeName("[ADDRESS:]PORT");
  AddHostNameOption(app, "metrics", options.host_names);
  app.Add("--event-log", options.event_log,
          "append sessions, refusals and faults to this file, one JSON object per line")
      .TypeName("FILE");
  AddNetworkOptions(app, "a station or viewer", options.network);
  AddCommonOptions(app, "number of the domain; only programs with the same number find each other",
                   options.domain, options.log_level);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  if (!options.host_names.empty() && !options.metrics) {
    throw UsageError("--host-name needs --metrics; give both or neither");
  }
  const bool of_mesh = !options.mesh.unit.empty() || options.mesh.ball_m > 0.0;
  if (of_mesh && std::ranges::none_of(options.scenes, IsMeshFile)) {
    throw UsageError(
        "--unit and --ball apply to meshes only, and none is given; a scene file states both "
        "itself");
  }
  return options;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-server", [&] {
    const auto options = palpate::ParseOptions(argc, argv);
    if (!options) return 0;
    palpate::SetUpLog("palpate-server", options->log_level);
    return palpate::Serve(*options);
  });
}
