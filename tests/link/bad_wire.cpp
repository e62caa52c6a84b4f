#include "tests/link/bad_wire.h"

#include <algorithm>

#include <arpa/inet.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "common/error.h"
#include "common/realtime/steady_clock.h"

namespace palpate::test {
namespace {

constexpr std::int64_t kStopSeen_ns = 10'000'000;
constexpr std::size_t kLargestFrame = 70'000;  // as before segmentation

int Open(const std::string& interface) {
  const int socket_fd =
      socket(AF_PACKET, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, htons(ETH_P_ALL));
  if (socket_fd < 0) throw Error("no packet socket: needs root");
  const int on = 1;
  // The header says which checksums and segments are still to be computed: veth leaves that to a
  // card.
  setsockopt(socket_fd, SOL_PACKET, PACKET_VNET_HDR, &on, sizeof on);
  setsockopt(socket_fd, SOL_PACKET, PACKET_IGNORE_OUTGOING, &on, sizeof on);
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_ALL);
  address.sll_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
  if (bind(socket_fd, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
    close(socket_fd);
    throw Error("no frames from interface " + interface);
  }
  return socket_fd;
}

}  // namespace

BadWire::BadWire(const std::string& one, const std::string& other, std::uint64_t seed,
                 const LinkConditions& each_way)
    : one_(Open(one)), other_(Open(other)), link_(seed, each_way), thread_([this] { Run(); }) {}

BadWire::~BadWire() {
  stop_ = true;
  thread_.join();
  close(one_);
  close(other_);
}

void BadWire::Take(int from, LossyWay<Frame>& way) {
  Frame frame(kLargestFrame);
  for (ssize_t size; (size = read(from, frame.data(), frame.size())) > 0;) {
    ++frames_;
    if (cut_) continue;
    way.Send(SteadyNanoseconds(), Frame(frame.begin(), frame.begin() + size));
  }
}

void BadWire::Give(int to, LossyWay<Frame>& way) {
  while (const std::optional<Frame> frame = way.Receive(SteadyNanoseconds())) {
    // A frame that cannot be sent counts as one more that is lost.
    [[maybe_unused]] const ssize_t sent = write(to, frame->data(), frame->size());
  }
}

void BadWire::Run() {
  while (!stop_) {
    const std::int64_t now_ns = SteadyNanoseconds();
    std::int64_t until_ns = now_ns + kStopSeen_ns;
    for (const LossyWay<Frame>* way : {&link_.up, &link_.down}) {
      if (const auto next = way->next_arrival_ns()) until_ns = std::min(until_ns, *next);
    }
    const timespec wait{0, std::max<std::int64_t>(0, until_ns - now_ns)};
    pollfd ends[] = {{one_, POLLIN, 0}, {other_, POLLIN, 0}};
    ppoll(ends, 2, &wait, nullptr);
    Take(one_, link_.up);
    Take(other_, link_.down);
    Give(other_, link_.up);
    Give(one_, link_.down);
  }
}

}  // namespace palpate::test
