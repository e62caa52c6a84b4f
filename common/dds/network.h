#pragma once

#include <string>
#include <vector>

namespace palpate::dds {

/// The network on which a program looks for others, and the identity that it uses.  The default is
/// this host alone: without an identity nothing is encrypted, and anybody who can send packets may
/// command the forces at a hand.
struct Network {
  std::string interface = "lo";
  /// Further addresses to contact, for networks without multicast.
  std::vector<std::string> peers;
  /// Folder of the program's identity in a secured domain (common/dds/security.h); empty: the
  /// domain is not secured.
  std::string identity;

  bool this_host() const { return interface == "lo"; }
  bool secured() const { return !identity.empty(); }
};

}  // namespace palpate::dds
