#include "client/doctor/network_checks.h"

#include <algorithm>
#include <set>
#include <sstream>

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include "common/dds/ports.h"
#include "common/dds/server_lock.h"
#include "common/dds/topics.h"

namespace palpate::doctor {

std::vector<Interface> InterfacesOfThisHost() {
  std::vector<Interface> interfaces;
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return interfaces;
  for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
    if (each->ifa_addr == nullptr || each->ifa_addr->sa_family != AF_INET) continue;
    interfaces.push_back({.name = each->ifa_name,
                          .up = (each->ifa_flags & IFF_UP) != 0,
                          .multicast = (each->ifa_flags & IFF_MULTICAST) != 0});
  }
  freeifaddrs(all);
  return interfaces;
}

Finding CheckNetwork(const std::vector<Interface>& interfaces, const dds::Network& network) {
  const auto found = std::ranges::find(interfaces, network.interface, &Interface::name);
  if (found == interfaces.end()) {
    std::string remedy = "give another --network; with an address are:";
    for (const Interface& each : interfaces) remedy += " " + each.name;
    return Fault(network.interface + " is not there, or has no address of IPv4",
                 network.this_host()
                     ? "sudo ip link set lo up && sudo ip address add 127.0.0.1/8 dev lo"
                     : remedy);
  }
  if (!found->up) {
    return Fault(network.interface + " is down", "sudo ip link set " + network.interface + " up");
  }
  // lo never says that it carries multicast, and does; the loop that is tried shows it.
  if (network.this_host() || found->multicast) return Ok(network.interface + " is up");
  const std::string poor = network.interface + " is up, without multicast";
  if (!network.peers.empty()) return Ok(poor);
  return Warning(poor, "give each program the other's address with --peer ADDRESS");
}

bool ServerRuns(const HostFiles& host, int domain) {
  std::istringstream sockets(host.Read("/proc/net/udp").value_or(""));
  return dds::PortsIn(sockets).contains(ServerPort(domain));
}

Finding CheckPorts(const HostFiles& host, int domain, bool server_runs) {
  std::set<int> in_use;
  for (const char* file : {"/proc/net/udp", "/proc/net/udp6"}) {
    std::istringstream text(host.Read(file).value_or(""));
    in_use.merge(dds::PortsIn(text));
  }
  std::istringstream range(host.Read("/proc/sys/net/ipv4/ip_local_port_range").value_or(""));
  const dds::PortRange anyone = dds::PortsOfAnyone(range);
  const dds::PortRange loop = dds::PortsOf(dds::LoopDomainId(domain));
  const dds::PortRange service = dds::PortsOf(dds::ServiceDomainId(domain));
  const std::string which = "domain " + std::to_string(domain) + ", UDP " +
                            std::to_string(loop.first) + " to " + std::to_string(service.last);
  if (loop.Meets(anyone) || service.Meets(anyone)) {
    return Warning(which + ": the kernel gives some of them to any connection (" +
                       std::to_string(anyone.first) + " to " + std::to_string(anyone.last) + ")",
                   "sudo sysctl net.ipv4.ip_local_port_range='32768 60999', and the same line in "
                   "/etc/sysctl.d/palpate.conf; or give a smaller --domain");
  }
  std::string why;
  for (const int id : {dds::LoopDomainId(domain), dds::ServiceDomainId(domain)}) {
    if (why.empty()) why = dds::WhyPortsFail(id, in_use, anyone);
  }
  if (why.empty()) return Ok(which + ": free");
  if (server_runs) return Ok(which + ": a palpate-server of this host has them");
  return Warning(
      which + ": taken, and no palpate-server of this host runs in it; " + why,
      "end what has them, unless it is a palpate-viewer or a station that waits for its server "
      "(sudo ss -ulpn names it), or give another --domain");
}

}  // namespace palpate::doctor
