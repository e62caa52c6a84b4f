#pragma once

#include <cstdint>
#include <istream>
#include <set>
#include <string>
#include <vector>

#include "common/dds/topics.h"

namespace palpate::dds {

// The UDP ports of a DDS domain.  RTPS gives each domain 250 ports from 7400 on (RTPS 2.3,
// 9.6.1.1).  From domain 102 on these lie in the kernel's ephemeral range (32768 to 60999 by
// default), whose ports go to any connection that asks for one, so such a domain would now and
// then fail to open.  With fewer ports each, every DDS domain of `--domain` lies below that range.
// Only the number of ports differs from the standard, so a foreign DDS tool needs one setting to
// join (server/limits.md).
//
//   first      first + 1     first + 10 + 2 i   first + 11 + 2 i     first + 108, + 109
//   multicast: discovery,    each process i:    discovery, data      of a loop domain: its server's
//   data                                                             (server_lock.h), its test's
inline constexpr int kFirstPort = 7400;
inline constexpr int kPortsPerDomain = 110;
/// The last i: 49 processes can be in a DDS domain on one host, where a server admits 32 stations.
inline constexpr int kMaxParticipantIndex = (kPortsPerDomain - 12) / 2 - 1;

struct PortRange {
  int first = 0;
  int last = 0;
  bool Has(int port) const { return first <= port && port <= last; }
  bool Meets(const PortRange& other) const { return first <= other.last && other.first <= last; }
};

/// Returns the ports of a DDS domain, given its own number (LoopDomainId, ServiceDomainId).
constexpr PortRange PortsOf(int domain_id) {
  const int first = kFirstPort + kPortsPerDomain * domain_id;
  return {first, first + kPortsPerDomain - 1};
}

struct UdpSocket {
  int port = 0;
  std::uint32_t user = 0;
  std::uint64_t inode = 0;
};
/// Returns all UDP sockets, from the text of /proc/net/udp.
std::vector<UdpSocket> UdpSocketsIn(std::istream& proc_net_udp);
/// Returns the UDP ports in use, from the same text.
std::set<int> PortsIn(std::istream& proc_net_udp);
/// On this host.
std::set<int> PortsInUse();

/// Returns the ephemeral ports, which the kernel gives to sockets that ask for any, from the text
/// of /proc/sys/net/ipv4/ip_local_port_range.
PortRange PortsOfAnyone(std::istream& ip_local_port_range);
/// On this host.
PortRange PortsOfAnyone();

/// Returns why a DDS domain could not be opened, judging by its ports, and which numbers of
/// `--domain` have free ports.  Empty if none of its ports is in use.
std::string WhyPortsFail(int domain_id, const std::set<int>& in_use, const PortRange& anyone);

}  // namespace palpate::dds
