#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "client/replayer/play/timeline.h"
#include "common/recording/recording_reader.h"

namespace palpate {

/// Reads a recording from any moment of its timeline on.
class Playhead {
 public:
  /// What streams, by its source: the latest of each.
  using Streams = std::map<Timeline::Source, std::vector<std::uint8_t>>;

  /// Both must outlive it; the timeline is finished, and of what the reader reads.
  Playhead(RecordingReader& reader, const Timeline& timeline)
      : reader_(reader), timeline_(timeline) {}

  /// To a moment: the next sample is the first after it.
  /// Returns what streamed last up to then, however long before: it is what who has played up to
  /// there still sees.
  Streams GoTo(std::int64_t time_ns);
  /// The next for viewers, until the playhead moves; false where there is none.
  bool Next(RecordedSample& sample);
  /// The turn of the sample that was read last.
  std::int64_t passed_ns() const { return passed_ns_; }

 private:
  /// Reads from before `from_ns` up to and with `to_ns`.
  /// @param only  of this source; null: of all.
  void Gather(std::int64_t from_ns, std::int64_t to_ns, const Timeline::Source* only,
              Streams& streams);

  RecordingReader& reader_;
  const Timeline& timeline_;
  std::optional<RecordedSample> ahead_;  // read already
  std::int64_t passed_ns_ = 0;
};

}  // namespace palpate
