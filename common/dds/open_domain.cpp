#include "common/dds/open_domain.h"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <new>
#include <set>

#include <linux/filter.h>
#include <malloc.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include "common/error.h"

namespace palpate::dds {
namespace {

namespace fs = std::filesystem;

/// Returns the port of a UDP socket; 0 if it is none.
int PortOf(int fd) {
  int type = 0;
  socklen_t size = sizeof type;
  if (getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) return 0;
  sockaddr_in place{};
  size = sizeof place;
  if (getsockname(fd, reinterpret_cast<sockaddr*>(&place), &size) != 0) return 0;
  return place.sin_family == AF_INET ? ntohs(place.sin_port) : 0;
}

void Attach(int fd, unsigned interface) {
  constexpr std::uint32_t kAll = 0xffff'ffff;
  std::array<sock_filter, 4> code{{
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(SKF_AD_OFF + SKF_AD_IFINDEX)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, interface, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, kAll),
      BPF_STMT(BPF_RET | BPF_K, 0),
  }};
  const sock_fprog program{code.size(), code.data()};
  if (setsockopt(fd, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof program) != 0) {
    throw Error(std::string("DDS cannot be restricted to this host: a socket accepts no filter (") +
                std::strerror(errno) + "); give --network, and protect that network");
  }
}

/// Returns the UDP sockets that this process has open.
std::set<int> UdpSockets() {
  std::set<int> sockets;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/proc/self/fd", error)) {
    const std::string name = entry.path().filename();
    int fd = -1;
    std::from_chars(name.data(), name.data() + name.size(), fd);
    if (PortOf(fd) != 0) sockets.insert(fd);
  }
  return sockets;
}

/// @param others  sockets that were open before the domain.
void HearThisHostAlone(const PortRange& ports, const std::set<int>& others) {
  const unsigned loopback = if_nametoindex("lo");
  int filtered = 0;
  for (const int fd : UdpSockets()) {
    if (others.contains(fd) || !ports.Has(PortOf(fd))) continue;
    Attach(fd, loopback);
    ++filtered;
  }
  if (filtered == 0) {
    throw Error(
        "DDS cannot be restricted to this host: /proc/self/fd shows none of its sockets; mount "
        "/proc");
  }
}

/// Throws std::bad_alloc if there is too little memory for a domain: Cyclone DDS would abort
/// without naming the cause.
void AskForMemory() {
  rlimit space{};
  if (getrlimit(RLIMIT_AS, &space) != 0 || space.rlim_cur == RLIM_INFINITY) return;
  // Otherwise each thread would reserve a heap of 64 MB, which the next thread's stack may need.
  mallopt(M_ARENA_MAX, 1);
  constexpr std::size_t kDomain_bytes = std::size_t{128} << 20;  // a dozen stacks of 8 MB, and more
  void* const place = mmap(nullptr, kDomain_bytes, PROT_READ | PROT_WRITE,
                           MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (place == MAP_FAILED) throw std::bad_alloc();
  munmap(place, kDomain_bytes);
}

}  // namespace

dds_entity_t OpenDomain(dds_domainid_t id, const std::string& config, const Network& network,
                        const PortRange& ports) {
  AskForMemory();
  const std::set<int> others = UdpSockets();
  const dds_entity_t domain = dds_create_domain(id, config.c_str());
  if (domain < 0 || !network.this_host()) return domain;
  try {
    HearThisHostAlone(ports, others);
  } catch (...) {
    dds_delete(domain);
    throw;
  }
  return domain;
}

}  // namespace palpate::dds
