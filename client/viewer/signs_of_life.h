#pragma once

#include <algorithm>
#include <cstdint>

namespace palpate {

/// Watches whether a viewer that holds a tool is still there: it is pinged after a second
/// of silence, then once a second, and given up after three.  Silence accumulates between
/// calls of Look, at most kMostOfALook_ns each, so that a stall of this process is not
/// taken for the viewer's.
/// Times are in nanoseconds.
class SignsOfLife {
 public:
  static constexpr std::int64_t kAskAfter_ns = 1'000'000'000;
  static constexpr std::int64_t kPatience_ns = 3'000'000'000;
  /// The most silence that one Look adds; it is called some 100 times a second.
  static constexpr std::int64_t kMostOfALook_ns = 100'000'000;

  /// Takes note of any message of the viewer, such as an answer to a ping.
  void Heard() { silent_ns_ = asked_ns_ = 0; }
  /// Returns false once the viewer is given up.
  bool Look(std::int64_t now_ns) {
    silent_ns_ += std::min(now_ns - looked_ns_, kMostOfALook_ns);
    looked_ns_ = now_ns;
    return silent_ns_ <= kPatience_ns;
  }
  /// Returns whether to ping now, and then takes the ping as sent.
  bool Ask() {
    if (silent_ns_ - asked_ns_ < kAskAfter_ns) return false;
    asked_ns_ = silent_ns_;
    return true;
  }

 private:
  std::int64_t looked_ns_ = 0;
  std::int64_t silent_ns_ = 0;  // silence so far
  std::int64_t asked_ns_ = 0;   // the silence at the last ping
};

}  // namespace palpate
