#pragma once

#include <algorithm>
#include <cstdint>

namespace palpate {

/// Whether a viewer that holds a tool is still there: asked after a second of silence, once a
/// second, and given up after three.  Silence is counted from look to look: while nobody looks, as
/// where the process is held up, or the viewer holds no tool, nothing could be heard.
/// Time is given [ns].
class SignsOfLife {
 public:
  static constexpr std::int64_t kAskAfter_ns = 1'000'000'000;
  static constexpr std::int64_t kPatience_ns = 3'000'000'000;
  /// Between two looks no more counts; they come some 100 times a second.
  static constexpr std::int64_t kMostOfALook_ns = 100'000'000;

  /// Anything has been heard of it, an answer to a ping, say.
  void Heard() { silent_ns_ = asked_ns_ = 0; }
  /// False once it is given up.
  bool Look(std::int64_t now_ns) {
    silent_ns_ += std::min(now_ns - looked_ns_, kMostOfALook_ns);
    looked_ns_ = now_ns;
    return silent_ns_ <= kPatience_ns;
  }
  /// True where it is to be asked now, which then counts as done.
  bool Ask() {
    if (silent_ns_ - asked_ns_ < kAskAfter_ns) return false;
    asked_ns_ = silent_ns_;
    return true;
  }

 private:
  std::int64_t looked_ns_ = 0;
  std::int64_t silent_ns_ = 0;  // so long
  std::int64_t asked_ns_ = 0;   // when it had been silent for so long
};

}  // namespace palpate
