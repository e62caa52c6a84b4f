#pragma once

#include <string>
#include <vector>

namespace palpate::dds {

/// Where others are looked for, and as whom one speaks.  By default on this host alone: without an
/// identity nothing that is sent is encrypted, and whoever can send may command a hand's forces.
struct Network {
  std::string interface = "lo";
  /// Addresses at which to look as well, for networks that carry no multicast.
  std::vector<std::string> peers;
  /// Folder of one's identity in a secured domain (common/dds/security.h); empty: it is not one.
  std::string identity;

  bool this_host() const { return interface == "lo"; }
  bool secured() const { return !identity.empty(); }
};

}  // namespace palpate::dds
