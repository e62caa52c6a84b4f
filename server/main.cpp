#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <malloc.h>
#include <spdlog/spdlog.h>

#include "common/dds/topics.h"
#include "common/error.h"
#include "common/log.h"
#include "common/realtime/realtime.h"
#include "common/server_lock.h"
#include "common/stop_signal.h"
#include "common/time/steady_clock.h"
#include "scenes/catalogue.h"
#include "scenes/scene_bundle.h"
#include "server/session/scene_model.h"
#include "server/transport/server.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPoll{5};

struct Options {
  std::vector<std::string> scenes;
  std::string transport = "auto";
  dds::Network network;
  std::string realtime = "prefer";
  int cpu = -1;
  std::string models;
  int domain = 0;
  std::string log_level = "info";
};

/// What stations can drive in a scene.  The scene itself (its meshes) is not kept.
void AddTools(const Scene& scene, std::vector<std::shared_ptr<const ServedTool>>& tools) {
  const auto objects = MakeObjects(scene);
  const auto whole = scene.features.removal ? std::make_shared<const SceneRemains>(scene) : nullptr;
  for (const Body& tool : scene.tools) {
    tools.push_back(std::make_shared<const ServedTool>(
        ServedTool{scene.name, tool.name, MakeModel(scene, tool, objects), whole}));
  }
}

int Serve(const Options& options) {
  StopSignal stop;
  const ServerLock lock(options.domain);
  const dds::TransportChoice transport =
      dds::ChooseTransport(dds::ParseTransport(options.transport), options.network);

  // The receiving threads, which are the servo loops, inherit what this thread has just now.
  const RealtimeReport realtime =
      EnterRealtime({.mode = ParseRealtimeMode(options.realtime), .cpu = options.cpu});
  dds::Participant loop_domain = dds::Participant::Loop(options.domain, transport, options.network);
  LeaveRealtime();

  LoadOptions load;
  load.models_dir = options.models;
  load.warn = [](const std::string& text) { spdlog::warn("{}", text); };
  std::vector<std::shared_ptr<const ServedTool>> tools;
  std::map<std::string, std::vector<std::uint8_t>> bundles;
  std::string names;
  for (const std::string& name : options.scenes) {
    const Scene scene = LoadScene(name, load);
    AddTools(scene, tools);
    bundles[scene.name] = PackScene(scene);
    names += (names.empty() ? "" : ", ") + scene.name;
  }
  malloc_trim(0);  // what the models were made from: as much again

  Server server(std::move(loop_domain), dds::Participant::Service(options.domain, options.network),
                std::move(tools), [](const std::string& line) {
                  std::puts(line.c_str());
                  std::fflush(stdout);
                });
  for (auto& [name, bundle] : bundles) server.PublishScene(name, std::move(bundle));
  std::printf("ready: scenes %s; transport %s; real-time %s; domain %d\n", names.c_str(),
              transport.reason.c_str(), realtime.summary.c_str(), options.domain);
  std::fflush(stdout);
  do {
    server.Poll(SteadyNanoseconds());
  } while (!stop.WaitFor(kPoll));
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  using namespace palpate;
  Options options;
  CLI::App app{
      "Serves scenes to haptic stations: each pose that a station sends is answered with the "
      "wrench "
      "that its tool meets.  Prints a line that begins with 'ready' once stations can connect, "
      "then "
      "a line of statistics per station and second."};
  app.footer(
      "Example: palpate-server --scene bunny-bunny\n"
      "then, in another terminal: palpate-station --device simulated --scene bunny-bunny --id "
      "left");
  app.add_option("--scene", options.scenes, "scenes to serve: names from the catalogue, or files")
      ->required();
  app.add_option("--transport", options.transport,
                 "auto: shared memory where RouDi answers, else UDP; shm or udp insist")
      ->capture_default_str();
  app.add_option("--realtime", options.realtime,
                 "require: fail without the rights; prefer: take what is granted; off")
      ->capture_default_str();
  app.add_option("--cpu", options.cpu, "core that the servo loops stay on (default: any)")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--models", options.models,
                 "folder with the meshes that are not installed (or PALPATE_MODELS)");
  app.add_option("--network", options.network.interface,
                 "network interface, where the stations are on other hosts; default: this host "
                 "alone.  Nothing that is "
                 "sent over it is encrypted")
      ->capture_default_str();
  app.add_option("--peer", options.network.peers,
                 "address of a station, where the network carries no multicast");
  app.add_option("--domain", options.domain, "which set of servers and stations this belongs to")
      ->check(CLI::Range(0, dds::kMaxDomain))
      ->capture_default_str();
  app.add_option("--log-level", options.log_level, "trace, debug, info, warn, error or off")
      ->capture_default_str();
  app.set_version_flag("--version", PALPATE_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : 2;
  }
  try {
    SetUpLog("palpate-server", options.log_level);
    return Serve(options);
  } catch (const UsageError& e) {
    std::fprintf(stderr, "palpate-server: %s\n", e.what());
    return 2;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "palpate-server: %s\n", e.what());
    return 1;
  }
}
