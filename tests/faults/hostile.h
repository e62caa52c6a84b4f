#pragma once

#include <cstdint>
#include <string>

namespace palpate::faults {

/// Writes samples of every service topic, and of the loop topics of the station that has a session,
/// whose fields are anything at all: NaN, infinity, texts with control characters, numbers beyond
/// every list.  Returns how many.
std::uint64_t FloodDomain(int domain, std::uint64_t seed, double seconds);

/// Sends anything at all to a port as HTTP and as WebSocket frames, in pieces, over many
/// connections. Returns how many.
std::uint64_t FloodPort(int port, std::uint64_t seed, double seconds);

/// Connections that begin a request and go on with a byte a second, while it lives.
class SlowLoris {
 public:
  SlowLoris(int port, int connections);
  ~SlowLoris();
  SlowLoris(const SlowLoris&) = delete;
  SlowLoris& operator=(const SlowLoris&) = delete;
  /// A byte more on each.
  void Go();

 private:
  int connections_[1000];
  int count_ = 0;
};

}  // namespace palpate::faults
