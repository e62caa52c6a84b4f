#include "client/crtk/bridge.h"

#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <set>
#include <string>

#include <spdlog/spdlog.h>

#include "client/crtk/crtk_station.h"
#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPoll{2};
/// As many as a server admits; of strangers' names no more are made into topics.
constexpr std::size_t kMostStations = 32;

using Stations = std::map<std::string, std::unique_ptr<CrtkStation>>;

/// Why a station cannot be brought to ROS; empty where it can.
std::string WhyLeftOut(const std::string& name, const Stations& stations) {
  if (!dds::IsStationName(name)) return "no such name";
  if (std::string why = WhyNoRosName(name); !why.empty()) return why;
  for (const auto& [other, station] : stations) {
    if (station->ros_namespace() == RosNamespace(name)) {
      return "station " + other + " has that name in ROS; give one of them another --id";
    }
  }
  return stations.size() == kMostStations ? "32 are here already" : "";
}

}  // namespace

void Bridge(const CrtkOptions& options, StopSignal& stop) {
  const dds::TransportChoice transport = dds::ChooseTransport(options.transport, options.network);
  const dds::Participant service = dds::Participant::Service(options.domain, options.network);
  const dds::Participant loop = dds::Participant::Loop(options.domain, transport, options.network);
  const ros2::Participant ros(options.ros_domain, options.ros_network);
  dds::Reader<wire::SessionState> states(service, dds::kSessionStateTopic,
                                         dds::Qos::kRecordSession);
  // Only who may command needs the right to (deploy/security/identities).
  dds::Writer<wire::GuideTarget> guide;
  dds::Writer<wire::OperateRequest> wishes;
  if (!options.read_only) {
    guide = {service, dds::kGuideTopic, dds::Qos::kStream};
    wishes = {service, dds::kOperateRequestTopic, dds::Qos::kSession};
  }
  const GuideLimits limits = GuideLimits::OfForce(options.guide_force_N);
  Stations stations;
  std::set<std::string> left_out;  // of which it has been told
  std::printf("ready: domain %d to ROS domain %d on %s; poses and wrenches: %s\n", options.domain,
              options.ros_domain, options.ros_network.interface.c_str(), transport.reason.c_str());
  std::fflush(stdout);

  const std::int64_t began_ns = SteadyNanoseconds();
  RateLimit words;
  while (!stop.WaitFor(kPoll)) {
    const std::int64_t now_ns = SteadyNanoseconds();
    if (options.seconds && 1e-9 * static_cast<double>(now_ns - began_ns) >= *options.seconds) break;
    for (wire::SessionState state; states.Take(state);) {
      auto it = stations.find(state.station);
      if (it == stations.end()) {
        if (state.phase == palpate_SESSION_ENDED || state.phase == palpate_SESSION_REFUSED)
          continue;
        if (const std::string why = WhyLeftOut(state.station, stations); !why.empty()) {
          if (left_out.size() < kMostStations && left_out.contains(state.station)) continue;
          if (words.Pass(now_ns)) {
            spdlog::warn("station {} is left out: {}", Quoted(state.station), why);
            if (left_out.size() < kMostStations) left_out.insert(state.station);
          }
          continue;
        }
        it = stations
                 .emplace(state.station,
                          std::make_unique<CrtkStation>(ros, state.station, options.read_only,
                                                        limits, guide, wishes))
                 .first;
        std::printf("station %s: %s/measured_cp and so on\n", state.station,
                    it->second->ros_namespace().c_str());
        std::fflush(stdout);
      }
      it->second->Hear(state, now_ns);
    }
    for (auto& [name, station] : stations) station->Poll(loop, now_ns);
  }
  for (const auto& [name, station] : stations) {
    const CrtkStation::Counts counts = station->counts();
    std::printf("station %s: %llu poses, %llu wrenches, missing %llu, refused %llu\n", name.c_str(),
                static_cast<unsigned long long>(counts.poses),
                static_cast<unsigned long long>(counts.wrenches),
                static_cast<unsigned long long>(counts.missing),
                static_cast<unsigned long long>(counts.refused));
  }
}

}  // namespace palpate
