#include "client/load/served_tools.h"

#include <chrono>
#include <map>

#include "common/dds/cdr_reader.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/time/steady_clock.h"
#include "scenes/scene_bundle.h"

namespace palpate {
namespace {

/// From a server's first scene to its last, where all are wanted.
constexpr std::int64_t kMoreScenes_ns = 500'000'000;

}  // namespace

std::vector<OfferedTool> AskForTools(const dds::Participant& service, int domain,
                                     const std::string& scene, double wait_s, StopSignal& stop) {
  dds::CdrReader<wire::SceneBundle> bundles(service, dds::kSceneBundleTopic, dds::Qos::kSession);
  std::map<std::string, std::vector<OfferedTool>> offered;  // by scene
  std::int64_t until_ns = SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * wait_s);
  dds::CdrSample raw;
  wire::SceneBundle bundle{};
  while (SteadyNanoseconds() < until_ns) {
    while (bundles.Take(raw, bundle)) {
      if (offered.empty()) until_ns = SteadyNanoseconds() + kMoreScenes_ns;
      const Scene served = UnpackScene({bundle.bundle._buffer, bundle.bundle._length},
                                       std::string("the server's scene ") + bundle.scene);
      std::vector<OfferedTool>& tools = offered[bundle.scene];
      tools.clear();
      for (const Body& tool : served.tools) tools.push_back({bundle.scene, tool.name, tool.X_WB});
    }
    if (!scene.empty() && offered.contains(scene)) break;
    if (stop.WaitFor(std::chrono::milliseconds(10))) break;
  }
  dds::FreeContents(bundle);
  if (stop.stopped()) return {};
  const std::string with_domain = " --domain " + std::to_string(domain);
  if (offered.empty()) {
    throw Error("no palpate-server answers in domain " + std::to_string(domain) +
                "; start 'palpate-server --scene " + (scene.empty() ? "cube" : scene) +
                with_domain + "', or give the --domain of one that runs");
  }
  std::vector<OfferedTool> tools;
  std::string names;
  for (const auto& [name, of_scene] : offered) {
    names += " " + name;
    if (scene.empty() || scene == name) tools.insert(tools.end(), of_scene.begin(), of_scene.end());
  }
  if (tools.empty()) {
    throw Error("the server of domain " + std::to_string(domain) + " has no scene '" + scene +
                "', but:" + names + "; give --scene one of these, or start it with yours");
  }
  return tools;
}

}  // namespace palpate
