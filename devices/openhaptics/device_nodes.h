#pragma once

#include <functional>
#include <string>
#include <vector>

namespace palpate {

/// Device nodes of the kinds that an arm can have: serial (Touch over USB), FireWire and parallel.
struct DeviceNodes {
  std::vector<std::string> open;    ///< those that this user may open
  std::vector<std::string> closed;  ///< those that this user may not open
};
/// Returns the nodes in a folder, ordered by name.
/// @param may_open  by default access(2) for reading and writing.
DeviceNodes FindDeviceNodes(const std::string& folder = "/dev",
                            const std::function<bool(const std::string&)>& may_open = {});

/// Describes, as a clause for a message, whether an arm seems to be connected: the nodes found, and
/// which of them this user may not open.
std::string DescribeDeviceNodes(const std::string& folder = "/dev",
                                const std::function<bool(const std::string&)>& may_open = {});

}  // namespace palpate
