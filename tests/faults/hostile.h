#pragma once

#include <cstdint>

namespace palpate::faults {

/// Writes samples of every service topic, and of the loop topics of the station that has a session,
/// with arbitrary fields: NaN, infinity, texts with control characters, enumerators that do not
/// exist. Returns how many.
std::uint64_t FloodDomain(int domain, std::uint64_t seed, double seconds);

/// Writes samples as a server, as stations and as replays would, each of a station, block or replay
/// that nobody has named before, under the run of the server that is there.  Returns how many.
std::uint64_t FloodNewKeys(int domain, double seconds);

/// Sends arbitrary bytes to a port as HTTP and as WebSocket frames, in pieces, over many
/// connections. Returns how many.
std::uint64_t FloodPort(int port, std::uint64_t seed, double seconds);

/// Connections that begin a request and send a byte more with each Go, while the object lives.
class SlowLoris {
 public:
  SlowLoris(int port, int connections);
  ~SlowLoris();
  SlowLoris(const SlowLoris&) = delete;
  SlowLoris& operator=(const SlowLoris&) = delete;
  void Go();

 private:
  int connections_[1000];
  int count_ = 0;
};

}  // namespace palpate::faults
