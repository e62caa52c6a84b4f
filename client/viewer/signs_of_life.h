#pragma once

#include <algorithm>
#include <cstdint>

namespace palpate {

/// Whether a viewer that holds a tool is still there: asked after a second of silence, once a
/// second, and given up after three.
/// Time is given [ns].
class SignsOfLife {
 public:
  static constexpr std::int64_t kAskAfter_ns = 1'000'000'000;
  static constexpr std::int64_t kPatience_ns = 3'000'000'000;

  /// Anything has been heard of it, an answer to a ping, say.
  void Heard(std::int64_t now_ns) { heard_ns_ = now_ns; }
  /// True where it is to be asked now, which then counts as done.
  bool Ask(std::int64_t now_ns) {
    if (now_ns - std::max(heard_ns_, asked_ns_) < kAskAfter_ns) return false;
    asked_ns_ = now_ns;
    return true;
  }
  bool gone(std::int64_t now_ns) const { return now_ns - heard_ns_ > kPatience_ns; }

 private:
  std::int64_t heard_ns_ = 0;
  std::int64_t asked_ns_ = 0;
};

}  // namespace palpate
