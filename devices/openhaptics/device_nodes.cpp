#include "devices/openhaptics/device_nodes.h"

#include <algorithm>
#include <filesystem>

#include <unistd.h>

namespace palpate {

DeviceNodes FindDeviceNodes(const std::string& folder,
                            const std::function<bool(const std::string&)>& may_open) {
  std::vector<std::string> found;
  std::error_code unreadable;
  for (const auto& entry : std::filesystem::directory_iterator(folder, unreadable)) {
    const std::string name = entry.path().filename();
    for (const char* begin : {"ttyACM", "fw", "parport"}) {
      if (name.starts_with(begin)) found.push_back(entry.path());
    }
  }
  std::sort(found.begin(), found.end());
  DeviceNodes nodes;
  for (const std::string& node : found) {
    const bool open = may_open ? may_open(node) : access(node.c_str(), R_OK | W_OK) == 0;
    (open ? nodes.open : nodes.closed).push_back(node);
  }
  return nodes;
}

std::string DescribeDeviceNodes(const std::string& folder,
                                const std::function<bool(const std::string&)>& may_open) {
  const DeviceNodes nodes = FindDeviceNodes(folder, may_open);
  const auto listed = [](const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += " " + name;
    return text;
  };
  if (!nodes.closed.empty()) {
    return "this user may not open" + listed(nodes.closed) +
           ": add it to the group that 'ls -l' shows there ('sudo usermod -aG dialout $USER') and "
           "log in again, or install the driver's udev rules";
  }
  if (!nodes.open.empty()) return "may be opened:" + listed(nodes.open);
  return "no arm is plugged in as far as " + folder +
         " shows (no ttyACM*, fw* or parport*): check cable and power (an arm on the network has "
         "no entry there)";
}

}  // namespace palpate
