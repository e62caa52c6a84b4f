#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "client/replayer/play/timeline.h"
#include "common/recording/recording_reader.h"

namespace palpate {

/// The position of a replay in its recording: follows the clock times a rate, pauses, and steps.
/// Time is an argument, so that tests need no clock.
class PlaybackClock {
 public:
  PlaybackClock(double rate, bool paused) : rate_(rate), paused_(paused) {}

  /// Starts at a time of the recording.
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

/// Reads a recording from any moment of its timeline.
class Playhead {
 public:
  /// The latest sample of each source that streams.
  using Streams = std::map<Timeline::Source, std::vector<std::uint8_t>>;

  /// Both must outlive it; the timeline must be finished and made from the reader's recording.
  Playhead(RecordingReader& reader, const Timeline& timeline)
      : reader_(reader), timeline_(timeline) {}

  /// Moves to a moment: the next sample is the first after it.  Returns the latest streamed
  /// sample of each source up to then, however old, since a viewer of the whole replay would
  /// still show it.
  Streams GoTo(std::int64_t time_ns);
  /// Reads the next sample for viewers; returns false if there is none.
  bool Next(RecordedSample& sample);
  /// Returns the turn (Timeline) of the last sample read.
  std::int64_t passed_ns() const { return passed_ns_; }

 private:
  /// Reads from before `from_ns` up to and including `to_ns`.
  /// @param only  this source only; null: all.
  void Gather(std::int64_t from_ns, std::int64_t to_ns, const Timeline::Source* only,
              Streams& streams);

  RecordingReader& reader_;
  const Timeline& timeline_;
  std::optional<RecordedSample> ahead_;  // already read, not yet returned
  std::int64_t passed_ns_ = 0;
};

}  // namespace palpate
