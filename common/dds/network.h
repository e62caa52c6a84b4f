#pragma once

#include <string>
#include <vector>

namespace palpate::dds {

/// Where others are looked for.  By default on this host alone: nothing that is sent is encrypted,
/// and whoever can send may command a hand's forces.
struct Network {
  std::string interface = "lo";
  /// Addresses at which to look as well, for networks that carry no multicast.
  std::vector<std::string> peers;

  bool this_host() const { return interface == "lo"; }
};

}  // namespace palpate::dds
