#include "tests/support/test_domain.h"

#include <cstdint>
#include <set>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/dds/ports.h"
#include "common/dds/topics.h"
#include "common/error.h"

namespace palpate::test {
namespace {

/// Returns a socket bound to the port; -1 if another process has it.
int Take(int port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  if (fd >= 0 && bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return fd;
  if (fd >= 0) close(fd);
  return -1;
}

/// Returns true if none of the DDS domain's ports is in use, except the one that reserves it.
bool NobodyIn(int domain_id, const std::set<int>& in_use) {
  const dds::PortRange ports = dds::PortsOf(domain_id);
  const auto next = in_use.lower_bound(ports.first);
  return next == in_use.end() || *next >= ports.last;
}

}  // namespace

int OwnDomain() {
  // Neither 0, which is for the user, nor the last, which is for palpate-bench.
  for (int domain = 1; domain < dds::kMaxDomain; ++domain) {
    const int loop = dds::LoopDomainId(domain);
    const int claim = Take(dds::PortsOf(loop).last);
    if (claim < 0) continue;
    const std::set<int> in_use = dds::PortsInUse();
    // Never closed: the reservation ends with this process.
    if (NobodyIn(loop, in_use) && NobodyIn(dds::ServiceDomainId(domain), in_use)) return domain;
    close(claim);
  }
  throw Error("no --domain is free on this host for a test");
}

}  // namespace palpate::test
