#pragma once

#include <cstdint>
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
  /// Bytes that a socket should hold until they are read; 0: 1 MB, as Cyclone DDS has it.  A host
  /// that allows less (net.core.rmem_max) gives less.
  std::uint32_t receive_buffer = 0;

  bool this_host() const { return interface == "lo"; }
  bool secured() const { return !identity.empty(); }
};

}  // namespace palpate::dds
