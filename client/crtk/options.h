#pragma once

#include <optional>
#include <string>

#include "client/station/guide.h"
#include "common/dds/participant.h"

namespace palpate {

struct CrtkOptions {
  int domain = 0;
  dds::Network network;
  dds::Transport transport = dds::Transport::kAuto;
  int ros_domain = 0;
  dds::Network ros_network;  ///< of ROS's side
  bool read_only = false;    ///< takes neither servo_cf nor state_command
  double guide_force_N = 0.5;
  std::optional<double> seconds;
  std::string log_level = "info";
};

/// Reads the command line.  For --help and --version prints them and returns nothing.
/// Throws UsageError.
std::optional<CrtkOptions> ParseOptions(int argc, const char* const* argv);

}  // namespace palpate
