#include "client/crtk/options.h"

#include <CLI/CLI.hpp>

#include "common/dds/ros2.h"
#include "common/program/command_line.h"

namespace palpate {
namespace {

constexpr const char* kAbout =
    R"(Makes each station an arm of the Collaborative Robotics Toolkit (CRTK) on ROS 2, without ROS here:
it speaks DDS with ROS 2's names.  Below a station's name it publishes measured_cp, measured_cv,
measured_cf and operating_state, and takes servo_cf and state_command.
)";

constexpr const char* kExamples =
    R"(Examples:
  palpate-crtk
      then, where ROS 2 is:  ros2 topic hz /hand/measured_cp
                             ros2 topic echo /hand/measured_cf geometry_msgs/msg/WrenchStamped
  palpate-crtk --ros-domain 7 --ros-network eth0
      for ROS_DOMAIN_ID=7 on other hosts
  palpate-crtk --read-only
      nobody in ROS's domain can pull a hand or pause a station

servo_cf pulls the hand at a station that runs with --accept-guide, at most with its --guide-force
(give the same number here), and is gone 100 ms after the last message.
state_command takes enable, disable, pause and resume.
Frames, time stamps and quality of service: client/crtk/README.md in the source tree, where the package
is installed /usr/share/doc/palpate-common/client/crtk/README.md.
Exit status: 0 done, 1 failed, 2 wrong usage.)";

}  // namespace

std::optional<CrtkOptions> ParseOptions(int argc, const char* const* argv) {
  CrtkOptions options;
  std::string transport = "auto";
  double seconds = 0.0;

  CLI::App app(kAbout, "palpate-crtk");
  app.footer(kExamples);
  app.add_option("--ros-domain", options.ros_domain,
                 "domain of the ROS 2 programs: their ROS_DOMAIN_ID")
      ->check(CLI::Range(0, ros2::kMaxDomain))
      ->capture_default_str();
  app.add_option("--ros-network", options.ros_network.interface,
                 "network interface of the ROS 2 programs, as eth0; lo: this host alone")
      ->capture_default_str();
  app.add_option("--ros-peer", options.ros_network.peers,
                 "address of a host with ROS, needed where the network carries no multicast; may "
                 "be given again");
  app.add_flag("--read-only", options.read_only, "take no servo_cf and no state_command");
  app.add_option("--guide-force", options.guide_force_N,
                 "force of servo_cf, in N, at which a station pulls with all of its --guide-force")
      ->check(CLI::Range(0.01, GuideLimits::kMostForce_N))
      ->capture_default_str();
  CLI::Option* for_option =
      app.add_option("--for", seconds, "end after this many seconds; default: at Ctrl-C")
          ->check(CLI::PositiveNumber);
  app.add_option("--transport", transport,
                 "how poses and wrenches travel, as for the server: auto, shm or udp")
      ->capture_default_str();
  AddNetworkOptions(app, "the server", options.network);
  AddCommonOptions(app, "the server's domain: the number that it was given", options.domain,
                   options.log_level);

  if (!ParseCommandLine(app, argc, argv)) return std::nullopt;

  if (*for_option) options.seconds = seconds;
  options.transport = dds::ParseTransport(transport);
  return options;
}

}  // namespace palpate
