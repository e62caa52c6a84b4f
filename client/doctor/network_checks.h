#pragma once

#include <string>
#include <vector>

#include "client/doctor/finding.h"
#include "client/doctor/host_files.h"
#include "common/dds/network.h"

namespace palpate::doctor {

/// A network interface with an address of IPv4.
struct Interface {
  std::string name;
  bool up = false;
  bool multicast = false;
};
std::vector<Interface> InterfacesOfThisHost();

/// Whether programs can meet over --network.
Finding CheckNetwork(const std::vector<Interface>& interfaces, const dds::Network& network);

/// Whether the UDP ports of --domain are free, or a palpate-server's.
/// @param server_runs  in this domain, on this host.
Finding CheckPorts(const HostFiles& host, int domain, bool server_runs);
/// A palpate-server of this host has this domain.
bool ServerRuns(const HostFiles& host, int domain);

}  // namespace palpate::doctor
