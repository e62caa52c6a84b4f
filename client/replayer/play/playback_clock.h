#pragma once

#include <cstdint>

namespace palpate {

/// Where a replay is in its recording: goes with the clock times a rate, pauses, and steps.  Time
/// is given, so that tests need no clock.
class PlaybackClock {
 public:
  PlaybackClock(double rate, bool paused) : rate_(rate), paused_(paused) {}

  /// Begins at a time of the recording.
  void Begin(std::int64_t recording_ns, std::int64_t now_ns) {
    recording_ns_ = recording_ns;
    since_ns_ = now_ns;
  }
  std::int64_t At(std::int64_t now_ns) const {
    if (paused_) return recording_ns_;
    return recording_ns_ +
           static_cast<std::int64_t>(rate_ * static_cast<double>(now_ns - since_ns_));
  }
  void SetPaused(bool paused, std::int64_t now_ns) {
    Begin(At(now_ns), now_ns);
    paused_ = paused;
  }
  void SetRate(double rate, std::int64_t now_ns) {
    Begin(At(now_ns), now_ns);
    rate_ = rate;
  }
  bool paused() const { return paused_; }
  double rate() const { return rate_; }

 private:
  double rate_;
  bool paused_;
  std::int64_t recording_ns_ = 0, since_ns_ = 0;
};

}  // namespace palpate
