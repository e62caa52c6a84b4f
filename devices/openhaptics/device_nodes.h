#pragma once

#include <functional>
#include <string>
#include <vector>

namespace palpate {

/// Nodes of the kinds that an arm has: serial (Touch over USB), FireWire and parallel.
struct DeviceNodes {
  std::vector<std::string> open;    ///< that this user may open
  std::vector<std::string> closed;  ///< and may not
};
/// In the folder, by name.
/// @param may_open  by default access(2) for reading and writing.
DeviceNodes FindDeviceNodes(const std::string& folder = "/dev",
                            const std::function<bool(const std::string&)>& may_open = {});

/// What speaks for or against an arm being plugged in, as a clause for a message: those nodes, and
/// which of them this user may not open.
std::string DescribeDeviceNodes(const std::string& folder = "/dev",
                                const std::function<bool(const std::string&)>& may_open = {});

}  // namespace palpate
