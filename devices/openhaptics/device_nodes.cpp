#include "devices/openhaptics/device_nodes.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include <unistd.h>

namespace palpate {

std::string DescribeDeviceNodes(const std::string& folder,
                                const std::function<bool(const std::string&)>& may_open) {
  std::vector<std::string> nodes;
  std::error_code unreadable;
  for (const auto& entry : std::filesystem::directory_iterator(folder, unreadable)) {
    const std::string name = entry.path().filename();
    for (const char* begin : {"ttyACM", "fw", "parport"}) {
      if (name.starts_with(begin)) nodes.push_back(entry.path());
    }
  }
  if (nodes.empty()) {
    return "no arm is plugged in as far as " + folder +
           " shows (no ttyACM*, fw* or parport*): check cable and power (an arm on the network has "
           "no entry there)";
  }
  std::sort(nodes.begin(), nodes.end());
  std::string closed;
  std::string all;
  for (const std::string& node : nodes) {
    const bool open = may_open ? may_open(node) : access(node.c_str(), R_OK | W_OK) == 0;
    (open ? all : closed) += " " + node;
  }
  if (!closed.empty()) {
    return "this user may not open" + closed +
           ": add it to the group that 'ls -l' shows there ('sudo usermod -aG dialout $USER') and "
           "log in again, or install the driver's udev rules";
  }
  return "may be opened:" + all;
}

}  // namespace palpate
