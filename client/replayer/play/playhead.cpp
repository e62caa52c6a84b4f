#include "client/replayer/play/playhead.h"

#include <utility>

namespace palpate {

Playhead::Streams Playhead::GoTo(std::int64_t time_ns) {
  Streams streams;
  for (const auto& [source, last_ns] : timeline_.QuietAt(time_ns)) {
    Gather(last_ns, last_ns, &source, streams);
  }
  Gather(time_ns - Timeline::kQuiet_ns, time_ns, nullptr, streams);
  return streams;
}

void Playhead::Gather(std::int64_t from_ns, std::int64_t to_ns, const Timeline::Source* only,
                      Streams& streams) {
  const Timeline::Start start = timeline_.StartFor(from_ns);
  reader_.GoTo(start.place);
  passed_ns_ = start.passed_ns;
  ahead_.reset();
  RecordedSample sample{};
  while (reader_.Next(sample)) {
    passed_ns_ = Timeline::TurnOf(sample, passed_ns_);
    if (passed_ns_ > to_ns) {
      ahead_ = sample;
      return;
    }
    if (!IsForViewers(sample.type) || Stays(sample.type)) continue;
    Timeline::Source source = Timeline::SourceOf(sample);
    if (only != nullptr && source != *only) continue;
    streams[std::move(source)].assign(sample.cdr.begin(), sample.cdr.end());
  }
}

bool Playhead::Next(RecordedSample& sample) {
  for (;;) {
    if (ahead_) {
      sample = *std::exchange(ahead_, std::nullopt);
    } else if (reader_.Next(sample)) {
      passed_ns_ = Timeline::TurnOf(sample, passed_ns_);
    } else {
      return false;
    }
    if (IsForViewers(sample.type)) return true;
  }
}

}  // namespace palpate
