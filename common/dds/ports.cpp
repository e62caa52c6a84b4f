#include "common/dds/ports.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace palpate::dds {
namespace {

constexpr int kFreeDomainsTold = 3;

bool AnyIn(const PortRange& ports, const std::set<int>& in_use) {
  const auto next = in_use.lower_bound(ports.first);
  return next != in_use.end() && *next <= ports.last;
}

std::string ToText(const PortRange& ports) {
  return std::to_string(ports.first) + " to " + std::to_string(ports.last);
}

/// Returns the free domains as "--domain 1, 2 or 4"; empty if none is free.
std::string FreeDomains(const std::set<int>& in_use) {
  std::vector<std::string> free;
  for (int domain = 0; domain <= kMaxDomain && free.size() < kFreeDomainsTold; ++domain) {
    if (AnyIn(PortsOf(LoopDomainId(domain)), in_use)) continue;
    if (AnyIn(PortsOf(ServiceDomainId(domain)), in_use)) continue;
    free.push_back(std::to_string(domain));
  }
  std::string text;
  for (std::size_t i = 0; i < free.size(); ++i) {
    text += (i == 0 ? "--domain " : i + 1 == free.size() ? " or " : ", ") + free[i];
  }
  return text;
}

}  // namespace

std::vector<UdpSocket> UdpSocketsIn(std::istream& proc_net_udp) {
  std::vector<UdpSocket> sockets;
  std::string line;
  std::getline(proc_net_udp, line);  // column headings
  while (std::getline(proc_net_udp, line)) {
    // "12: 0100007F:1CE8 00000000:0000 07 0:0 00:0 0 1000 0 5678 ...": number, own address and port
    // in hexadecimal digits, ..., user, ..., inode.
    std::istringstream words(line);
    std::string number, address, skipped;
    words >> number >> address;
    const std::size_t port = address.find(':');
    if (port == std::string::npos) continue;
    UdpSocket socket;
    socket.port = static_cast<int>(std::strtol(address.c_str() + port + 1, nullptr, 16));
    for (int i = 0; i < 5; ++i) words >> skipped;
    words >> socket.user >> skipped >> socket.inode;
    sockets.push_back(socket);
  }
  return sockets;
}

std::set<int> PortsIn(std::istream& proc_net_udp) {
  std::set<int> ports;
  for (const UdpSocket& socket : UdpSocketsIn(proc_net_udp)) ports.insert(socket.port);
  return ports;
}

std::set<int> PortsInUse() {
  std::set<int> ports;
  for (const char* file : {"/proc/net/udp", "/proc/net/udp6"}) {
    std::ifstream in(file);
    ports.merge(PortsIn(in));
  }
  return ports;
}

PortRange PortsOfAnyone(std::istream& ip_local_port_range) {
  PortRange ports{32768, 60999};  // the kernel's default, if it cannot be read
  if (PortRange read; ip_local_port_range >> read.first >> read.last) ports = read;
  return ports;
}

PortRange PortsOfAnyone() {
  std::ifstream in("/proc/sys/net/ipv4/ip_local_port_range");
  return PortsOfAnyone(in);
}

std::string WhyPortsFail(int domain_id, const std::set<int>& in_use, const PortRange& anyone) {
  const PortRange ports = PortsOf(domain_id);
  if (!AnyIn(ports, in_use)) return "";
  std::string text = "of its UDP ports, " + ToText(ports) + ", other programs have ";
  const auto taken =
      std::count_if(in_use.begin(), in_use.end(), [&](int port) { return ports.Has(port); });
  text += std::to_string(taken) + " (the first is " +
          std::to_string(*in_use.lower_bound(ports.first)) + ")";
  if (ports.Meets(anyone)) {
    text += "; the kernel gives those from " + ToText(anyone) +
            " to any connection: begin them above " +
            std::to_string(PortsOf(ServiceDomainId(kMaxDomain)).last) +
            " (sysctl net.ipv4.ip_local_port_range)";
  }
  const std::string free = FreeDomains(in_use);
  return text + (free.empty() ? "; no other --domain is free either: end some of them"
                              : "; free on this host: " + free);
}

}  // namespace palpate::dds
