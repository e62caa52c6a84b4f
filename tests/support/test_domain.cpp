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

/// A socket that has the port to itself; -1 where another has it.
int Take(int port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  if (fd >= 0 && bind(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return fd;
  if (fd >= 0) close(fd);
  return -1;
}

/// True where nobody has one of the DDS domain's ports, but for the one that claims it.
bool NobodyIn(int domain_id, const std::set<int>& in_use) {
  const dds::PortRange ports = dds::PortsOf(domain_id);
  const auto next = in_use.lower_bound(ports.first);
  return next == in_use.end() || *next >= ports.last;
}

}  // namespace

int OwnDomain() {
  // Not 0, which is the user's own, nor the last, which is palpate-bench's.
  for (int domain = 1; domain < dds::kMaxDomain; ++domain) {
    const int loop = dds::LoopDomainId(domain);
    const int claim = Take(dds::PortsOf(loop).last);
    if (claim < 0) continue;
    const std::set<int> in_use = dds::PortsInUse();
    // Never closed: the claim goes with this process.
    if (NobodyIn(loop, in_use) && NobodyIn(dds::ServiceDomainId(domain), in_use)) return domain;
    close(claim);
  }
  throw Error("no --domain is free on this host for a test");
}

}  // namespace palpate::test
