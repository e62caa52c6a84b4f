#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sstream>

#include <fcntl.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/un.h>
#include <unistd.h>

#include "client/doctor/checks.h"
#include "common/dds/ports.h"
#include "common/dds/server_lock.h"
#include "common/dds/topics.h"
#include "common/text/quoted.h"

namespace palpate::doctor {
namespace {

constexpr const char* kSocket = "/tmp/roudi";                 // iceoryx 2.0: IPC channel "roudi"
constexpr const char* kLock = "/tmp/iox-unique-roudi.lock";   // held while RouDi lives
constexpr const char* kManagement = "/dev/shm/iceoryx_mgmt";  // RouDi's management data
constexpr long long kMega = 1'000'000;

/// Returns whether the user may open the socket; sets `answers` if a process holds it open.
bool Connects(const std::string& path, bool& answers) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return false;
  std::strcpy(address.sun_path, path.c_str());
  const int fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  answers = connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  const bool refused = !answers && (errno == EACCES || errno == EPERM);
  close(fd);
  return !refused;
}

bool IsLocked(const std::string& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;  // the file belongs to another user
  const bool locked = flock(fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(fd);
  return locked;
}

/// Returns the pools with which iox-roudi was started, from its command line.
std::optional<std::string> PoolsOfRunning(const HostFiles& host) {
  for (const std::string& process : host.Names("/proc")) {
    if (host.Read("/proc/" + process + "/comm") != "iox-roudi") continue;
    const std::string words = host.Read("/proc/" + process + "/cmdline").value_or("");
    // Each argument ends with a zero byte.
    for (const char* name : {"-c", "--config-file"}) {
      const std::string option = std::string(1, '\0') + name + std::string(1, '\0');
      if (const std::size_t at = words.find(option); at != std::string::npos) {
        return std::string(words.c_str() + at + option.size());
      }
    }
    return "";
  }
  return std::nullopt;
}

/// Returns a fault if the item must be right, otherwise a warning.
Finding Found(bool must, std::string found, std::string remedy) {
  return must ? Fault(std::move(found), std::move(remedy))
              : Warning(std::move(found), std::move(remedy));
}

}  // namespace

std::optional<Space> SpaceIn(const HostFiles& host, const std::string& folder) {
  struct statvfs status {};
  if (statvfs(host.At(folder).c_str(), &status) != 0) return std::nullopt;
  const auto block = static_cast<long long>(status.f_frsize);
  return Space{.size_MB = static_cast<long long>(status.f_blocks) * block / kMega,
               .free_MB = static_cast<long long>(status.f_bavail) * block / kMega};
}

RouDiState LookAtRouDi(const HostFiles& host) {
  RouDiState roudi;
  struct stat status {};
  roudi.socket = stat(host.At(kSocket).c_str(), &status) == 0;
  if (roudi.socket) {
    roudi.owner = status.st_uid;
    roudi.may_connect = Connects(host.At(kSocket), roudi.answers);
  }
  const auto closed = [&](const char* file) { return host.Has(file) && !host.MayOpen(file); };
  for (const char* file : {kLock, kManagement}) {
    if (closed(file)) roudi.closed.append(" ").append(file);
  }
  roudi.lock_held = closed(kLock) ? roudi.answers : IsLocked(host.At(kLock));
  roudi.pools = PoolsOfRunning(host);
  return roudi;
}

Finding CheckSharedMemory(const std::optional<Space>& space, bool roudi_runs,
                          dds::Transport wanted) {
  if (!space) {
    return Found(wanted != dds::Transport::kUdp, "is not there",
                 "sudo mount -t tmpfs tmpfs /dev/shm");
  }
  const std::string found =
      std::to_string(space->free_MB) + " of " + std::to_string(space->size_MB) + " MB free";
  const bool enough = roudi_runs || space->free_MB >= kSharedMemoryNeeded_MB;
  if (enough || wanted == dds::Transport::kUdp) return Ok(found);
  return Found(wanted == dds::Transport::kSharedMemory,
               found + ": RouDi needs " + std::to_string(kSharedMemoryNeeded_MB) +
                   " MB, and crashes (SIGBUS) with less",
               space->size_MB < kSharedMemoryNeeded_MB
                   ? "sudo mount -o remount,size=256m /dev/shm; in a container, --ipc host or "
                     "--shm-size 256m"
                   : "'ls -l /dev/shm' shows who uses it: end those programs, and remove files of "
                     "ended ones (iceoryx_*, if no RouDi runs)");
}

Finding CheckRouDi(const RouDiState& roudi, dds::Transport wanted, long long user,
                   const std::string& pools) {
  const std::string start =
      "sudo systemctl start palpate-roudi (package palpate-server), or iox-roudi -c " +
      ShellWord(pools) + " as the user of the server and the stations";
  const bool needed = wanted != dds::Transport::kUdp;
  const bool must = wanted == dds::Transport::kSharedMemory;
  const std::string owner = std::to_string(roudi.owner);
  if (!roudi.closed.empty() && !roudi.socket && needed) {
    return Found(must,
                 "the RouDi of another user left" + roudi.closed +
                     ", or runs with another /tmp; this user cannot start one",
                 "if 'pgrep iox-roudi' finds none: sudo rm" + roudi.closed + "; then " + start);
  }
  if (!roudi.answers && !roudi.lock_held) {
    const std::string found =
        roudi.socket ? "does not run; a killed one left its socket, /tmp/roudi" : "does not run";
    if (!needed) return Ok(found);
    return Found(must, found + ": programs use UDP", start);
  }
  if (roudi.socket && !roudi.may_connect) {
    const std::string found =
        "runs as another user (id " + owner + "), whose socket this user cannot open";
    if (!needed) return Ok(found);
    return Found(must, found,
                 "run RouDi, server and stations as the same user; or, if RouDi runs as the "
                 "service palpate-roudi, sudo adduser $USER palpate and log in again");
  }
  if (roudi.answers && !roudi.lock_held) {
    return Found(needed,
                 "a program other than RouDi (it does not hold " + std::string(kLock) +
                     ") listens at /tmp/roudi, of user id " + owner,
                 "sudo ss -xlp | grep /tmp/roudi names the process; end it, then " + start);
  }
  if (!roudi.answers) {
    const std::string found = "holds its lock, but does not answer at /tmp/roudi";
    if (!needed) return Ok(found);
    return Fault(found,
                 "share the host's /tmp (a container: --volume /tmp:/tmp; a service: "
                 "PrivateTmp=no), or restart it with server and stations");
  }
  const std::string found = roudi.owner == user ? "answers" : "answers, as user id " + owner;
  if (!roudi.pools) return Ok(found);  // unknown: it runs in another process namespace
  if (!roudi.pools->empty()) return Ok(found + ", with the pools of " + *roudi.pools);
  return Warning(found + ", with default pools (149 MB): it was started without -c",
                 "end it with server and stations, then " + start);
}

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
    std::string remedy = "give another --network; interfaces with an address:";
    for (const Interface& each : interfaces) remedy += " " + each.name;
    return Fault(network.interface + " does not exist, or has no IPv4 address",
                 network.this_host()
                     ? "sudo ip link set lo up && sudo ip address add 127.0.0.1/8 dev lo"
                     : remedy);
  }
  if (!found->up) {
    return Fault(network.interface + " is down", "sudo ip link set " + network.interface + " up");
  }
  // lo does not report that it carries multicast, but does; the trial loop shows it.
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
    return Warning(which + ": the kernel may assign some of them to other connections (" +
                       std::to_string(anyone.first) + " to " + std::to_string(anyone.last) + ")",
                   "sudo sysctl net.ipv4.ip_local_port_range='32768 60999', and the same line in "
                   "/etc/sysctl.d/palpate.conf; or give a smaller --domain");
  }
  std::string why;
  for (const int id : {dds::LoopDomainId(domain), dds::ServiceDomainId(domain)}) {
    if (why.empty()) why = dds::WhyPortsFail(id, in_use, anyone);
  }
  if (why.empty()) return Ok(which + ": free");
  if (server_runs) return Ok(which + ": used by a palpate-server of this host");
  return Warning(which + ": in use, but not by a palpate-server of this host; " + why,
                 "end the program that uses them ('sudo ss -ulpn' names it), unless it is a "
                 "palpate-viewer or a station that waits for its server; or give another --domain");
}

Finding CheckReceiveBuffer(const HostFiles& host) {
  constexpr long long kEnough = 4 << 20;  // more than a second of one station
  const auto most = host.ReadNumber("/proc/sys/net/core/rmem_max");
  if (!most) return Ok("how much a socket holds is not to be seen here");
  const std::string found = "a socket holds " + std::to_string(*most / 1024) + " kB";
  if (*most >= kEnough) return Ok(found);
  return Warning(found + ": on a busy host, recorders over UDP lose poses",
                 "sudo sysctl net.core.rmem_max=16777216, and the same line in "
                 "/etc/sysctl.d/palpate.conf");
}

}  // namespace palpate::doctor
