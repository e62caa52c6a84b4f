#include "client/station/served_tools.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <span>

#include "common/dds/cdr_reader.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/realtime/steady_clock.h"
#include "common/text/joined.h"

namespace palpate {
namespace {

/// Reads the newest server's offer, once there is one.
class OfferReader {
 public:
  explicit OfferReader(const dds::Participant& service)
      : service_(service), reader_(service, dds::kSceneOfferTopic, dds::Qos::kSession) {}
  ~OfferReader() { dds::FreeContents(offer_); }

  bool Take() {
    dds::CdrSample raw;
    bool any = false;
    while (reader_.Take(raw, offer_)) any = true;
    return any;
  }
  /// Returns whether a server's offer cannot be read by this program's version.
  bool is_of_another_version() const {
    return reader_.matched_writers() == 0 && dds::WriterDiscovered(service_, dds::kSceneOfferTopic);
  }
  std::span<const wire::OfferedScene> scenes() const {
    return {offer_.scenes._buffer, offer_.scenes._length};
  }

 private:
  const dds::Participant& service_;
  dds::CdrReader<wire::SceneOffer> reader_;
  wire::SceneOffer offer_{};
};

/// Throws Error if the scripted hand is not one that can be followed.
template <class Sequence>
std::optional<PoseScript> ToHand(const Sequence& sequence) {
  std::vector<PoseScript::Key> keys;
  for (const wire::HandKey& key : std::span(sequence._buffer, sequence._length)) {
    const Pose X_WH = wire::ToPose(key.position_m, key.orientation_wxyz);
    const double size = X_WH.q.norm();
    if (!X_WH.p.allFinite() || !std::isfinite(size) || !(size > 0.5) ||
        !std::isfinite(key.time_s)) {
      throw Error(
          "the server's script for the hand is invalid; give one with --script, or start a "
          "palpate-server of this version");
    }
    keys.push_back({key.time_s, {X_WH.p, X_WH.q.normalized()}, key.label});
  }
  if (keys.empty()) return std::nullopt;
  return PoseScript(std::move(keys));
}

bool IsMeant(const wire::OfferedScene& offered, const std::string& scene) {
  if (scene.empty() || scene == offered.scene) return true;
  return std::filesystem::path(scene).filename() == offered.file;
}

void AddTools(const wire::OfferedScene& scene, std::vector<OfferedTool>& tools) {
  const std::optional<PoseScript> script = ToHand(scene.hand);
  for (const wire::OfferedTool& offered : std::span(scene.tools._buffer, scene.tools._length)) {
    OfferedTool& tool = tools.emplace_back();
    tool.scene = scene.scene;
    tool.tool = offered.tool;
    tool.X_WT = wire::ToPose(offered.start_position_m, offered.start_orientation_wxyz);
    tool.hand = ToHand(offered.hand);
    if (!tool.hand) tool.hand = script;
    tool.remark = offered.remark;
  }
}

}  // namespace

std::vector<OfferedTool> AskForTools(const dds::Participant& service, const AskOptions& options,
                                     const std::string& scene, const WaitOrStop& wait) {
  OfferReader offer(service);
  const std::int64_t until_ns =
      SteadyNanoseconds() + static_cast<std::int64_t>(1e9 * options.wait_s);
  while (!offer.Take()) {
    if (SteadyNanoseconds() > until_ns) {
      throw Error(offer.is_of_another_version()
                      ? AnotherVersionIsThere(options.domain)
                      : NobodyAnswers(options.domain, options.network, scene));
    }
    if (wait(std::chrono::milliseconds(10))) return {};
  }
  std::vector<OfferedTool> tools;
  for (const wire::OfferedScene& offered : offer.scenes()) {
    if (IsMeant(offered, scene)) AddTools(offered, tools);
  }
  if (tools.empty()) {
    throw Error("scene '" + scene + "' is not served here; choose one of: " +
                Joined(offer.scenes(), [](const auto& offered) { return offered.scene; }) +
                ", or start palpate-server with yours (--domain " + std::to_string(options.domain) +
                ")");
  }
  return tools;
}

const OfferedTool& Meant(const std::vector<OfferedTool>& tools, const std::string& name) {
  const auto found =
      std::ranges::find_if(tools, [&](const OfferedTool& tool) { return tool.tool == name; });
  return found == tools.end() ? tools.front() : *found;
}

std::string NobodyAnswers(int domain, const dds::Network& network, const std::string& scene) {
  const std::string number = std::to_string(domain);
  const std::string start =
      "palpate-server --scene " + (scene.empty() ? "cube" : scene) + " --domain " + number;
  // Participants with an identity do not hear those without one, or with another authority's.
  const std::string identity = network.secured()
                                   ? "; a server without --identity, or with one of another "
                                     "authority, does not hear this one"
                                   : "; where it has an --identity, give one of the same authority";
  if (network.this_host()) {
    return "no server answers in domain " + number + " of this host; start '" + start +
           "', give the --domain of one that runs, or --network where it runs on another host" +
           identity;
  }
  return "no server answers in domain " + number + " over " + network.interface + "; start '" +
         start +
         " --network INTERFACE' there; where the network carries no multicast, give --peer ADDRESS "
         "here or there" +
         identity;
}

std::string AnotherVersionIsThere(int domain) {
  return "a server runs in domain " + std::to_string(domain) +
         ", and is of another version than this program (" PALPATE_VERSION
         "), so they cannot communicate; install the same version on both, or give the --domain of "
         "another server";
}

}  // namespace palpate
