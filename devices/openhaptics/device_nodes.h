#pragma once

#include <functional>
#include <string>

namespace palpate {

/// What speaks for or against an arm being plugged in, as a clause for a message: serial (Touch
/// over USB), FireWire and parallel nodes in `folder`, and which of them this user may not open.
/// @param may_open  by default access(2) for reading and writing.
std::string DescribeDeviceNodes(const std::string& folder = "/dev",
                                const std::function<bool(const std::string&)>& may_open = {});

}  // namespace palpate
