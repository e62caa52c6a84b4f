#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/simulated_link.h"

namespace palpate::test {

/// A wire between two network interfaces of this host: each Ethernet frame that leaves one enters
/// the other, when and as often as LinkConditions say.  Like `tc netem`, but without its kernel
/// module, and with the same random numbers as the tests in virtual time.
class BadWire {
 public:
  /// Throws Error without the right to raw frames (root, or CAP_NET_RAW).
  BadWire(const std::string& one, const std::string& other, std::uint64_t seed,
          const LinkConditions& each_way);
  ~BadWire();
  BadWire(const BadWire&) = delete;
  BadWire& operator=(const BadWire&) = delete;

  /// Loses every frame from now on, or again only its share.
  void Cut(bool cut) { cut_ = cut; }
  std::uint64_t frames() const { return frames_; }  ///< received from both ends

 private:
  using Frame = std::vector<std::uint8_t>;

  void Run();
  void Take(int from, LossyWay<Frame>& way);
  void Give(int to, LossyWay<Frame>& way);

  int one_;
  int other_;
  SimulatedLink<Frame, Frame> link_;
  std::atomic<std::uint64_t> frames_{0};
  std::atomic<bool> cut_{false};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace palpate::test
