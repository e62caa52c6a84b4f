#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include <spdlog/spdlog.h>

#include "client/crtk/crtk_station.h"
#include "common/dds/participant.h"
#include "common/dds/phase_name.h"
#include "common/dds/ros2.h"
#include "common/dds/topics.h"
#include "common/program/command_line.h"
#include "common/program/stop_signal.h"
#include "common/realtime/steady_clock.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr std::chrono::milliseconds kPoll{2};
/// As many stations as a server admits; further names, from unknown senders, get no topics.
constexpr std::size_t kMostStations = 32;

constexpr const char* kAbout =
    R"(Bridges stations to ROS 2, each as an arm of the Collaborative Robotics Toolkit.
It needs no ROS on this host: it uses DDS with the names of ROS 2.  Under the
name of each station it publishes measured_cp, measured_cv, measured_cf and
operating_state, and subscribes to servo_cf and state_command (CRTK).
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-crtk
      then, on a host with ROS 2:
      ros2 topic hz /hand/measured_cp
      ros2 topic echo /hand/measured_cf geometry_msgs/msg/WrenchStamped
  palpate-crtk --ros-domain 7 --ros-network eth0
      for other hosts with ROS_DOMAIN_ID=7
  palpate-crtk --read-only
      nobody in the ROS domain can pull a hand or pause a station

servo_cf pulls the hand at a station that runs with --accept-guide, at most with
the station's --guide-force (give the same number here).  It ends 100 ms after
the last message.  state_command accepts enable, disable, pause and resume.
Frames, time stamps and quality of service: client/crtk/README.md in the source
tree; as a package, /usr/share/doc/palpate-common/client/crtk/README.md.
Exit status: 0 done, 1 failed, 2 wrong usage.)";

struct Options : ServerOptions {
  dds::Transport transport = dds::Transport::kAuto;
  int ros_domain = 0;
  dds::Network ros_network;  ///< of ROS's side
  bool read_only = false;    ///< takes neither servo_cf nor state_command
  double guide_force_N = 0.5;
  std::optional<double> seconds;
};

/// Returns nothing after --help or --version.  Throws UsageError.
std::optional<Options> ParseOptions(int argc, const char* const* argv) {
  Options options;
  const CommandLine app(kAbout, "palpate-crtk", kExamples);
  app.Add("--ros-domain", options.ros_domain, "domain of the ROS 2 programs (their ROS_DOMAIN_ID)")
      .Range(0, ros2::kMaxDomain)
      .ShowDefault();
  app.Add("--ros-network", options.ros_network.interface,
          "network interface to the ROS 2 programs, such as eth0; lo: this host only")
      .ShowDefault();
  app.Add("--ros-peer", options.ros_network.peers,
          "address of a host with ROS; needed if the network has no multicast; can be repeated");
  app.AddFlag("--read-only", options.read_only, "ignore servo_cf and state_command");
  app.Add("--guide-force", options.guide_force_N,
          "force of servo_cf, in N, that makes a station pull with its full --guide-force")
      .Range(0.01, GuideLimits::kMostForce_N)
      .ShowDefault();
  app.Add("--for", options.seconds, "end after this many seconds; default: at Ctrl-C").Positive();
  AddTransportOption(app, options.transport);
  AddServerOptions(app, options);
  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;
  return options;
}

using Stations = std::map<std::string, std::unique_ptr<CrtkStation>>;

/// Returns why a station cannot be bridged to ROS; empty if it can.
std::string WhyLeftOut(const std::string& name, const Stations& stations) {
  if (!dds::IsStationName(name)) return "its name is invalid; give --id letters, digits or _";
  if (std::string why = WhyNoRosName(name); !why.empty()) return why;
  for (const auto& [other, station] : stations) {
    if (station->ros_namespace() == RosNamespace(name)) {
      return "station " + other + " has the same name in ROS; give one of them another --id";
    }
  }
  return stations.size() == kMostStations ? "32 stations, the maximum, are bridged already" : "";
}

/// Bridges the stations of one server to ROS 2 until it is stopped.  Throws Error.
int Bridge(const Options& options) {
  StopSignal stop;
  const dds::TransportChoice transport = dds::ChooseTransport(options.transport, options.network);
  const dds::Participant service = dds::Participant::Service(options.domain, options.network);
  const dds::Participant loop = dds::Participant::Loop(options.domain, transport, options.network);
  const ros2::Participant ros(options.ros_domain, options.ros_network);
  dds::Reader<wire::SessionState> states(service, dds::kSessionStateTopic,
                                         dds::Qos::kRecordSession);
  // Only a bridge that may command needs this right (deploy/security/identities).
  dds::Writer<wire::GuideTarget> guide;
  dds::Writer<wire::OperateRequest> wishes;
  if (!options.read_only) {
    guide = {service, dds::kGuideTopic, dds::Qos::kStream};
    wishes = {service, dds::kOperateRequestTopic, dds::Qos::kSession};
  }
  const GuideLimits limits = GuideLimits::OfForce(options.guide_force_N);
  Stations stations;
  std::set<std::string> left_out;  // already reported
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
        if (IsOver(state)) continue;
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
  return 0;
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunProgram("palpate-crtk", argc, argv, palpate::ParseOptions, palpate::Bridge);
}
