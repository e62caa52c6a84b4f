#include "client/load/frame_tally.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "common/text/number_of.h"

namespace palpate {

FrameTally::FrameTally(Setup setup)
    : setup_(std::move(setup)), got_(setup_.viewers * setup_.stations) {}

std::size_t FrameTally::StationOf(const char* name) const {
  const std::string_view text(name);
  const std::string& ours = setup_.name;
  if (!text.starts_with(ours) || text.size() < ours.size() + 2 || text[ours.size()] != '_') {
    return setup_.stations;
  }
  const std::size_t number = NumberOf<std::size_t>(text.substr(ours.size() + 1)).value_or(0);
  return number >= 1 && number <= setup_.stations ? number - 1 : setup_.stations;
}

std::vector<std::uint64_t> FrameTally::NewestSequences() const {
  std::vector<std::uint64_t> sequences(setup_.stations);
  for (std::size_t i = 0; i < sequences.size(); ++i) sequences[i] = setup_.newest_sequence(i);
  return sequences;
}

void FrameTally::Begin(std::int64_t now_ns) {
  first_ = last_ = NewestSequences();
  begin_ns_.store(now_ns, std::memory_order_relaxed);
}

void FrameTally::End(std::int64_t now_ns) {
  end_ns_.store(now_ns, std::memory_order_relaxed);
  last_ = NewestSequences();
}

void FrameTally::Add(std::size_t viewer, const wire::ToolState& frame, std::int64_t now_ns) {
  if (now_ns < begin_ns_.load(std::memory_order_relaxed) ||
      now_ns >= end_ns_.load(std::memory_order_relaxed)) {
    return;
  }
  frames_.fetch_add(1, std::memory_order_relaxed);
  const std::size_t station = StationOf(frame.station);
  if (station == setup_.stations) return;
  const std::int64_t sampled_ns = setup_.sample_time_ns(station, frame.pose_sequence);
  age_.Add(sampled_ns != 0 ? now_ns - sampled_ns : kForgotten_ns);
  Got& got = got_[viewer * setup_.stations + station];
  if (frame.pose_sequence <= got.newest) return;
  got.newest = frame.pose_sequence;
  ++got.frames;
}

std::uint64_t FrameTally::DueOf(std::size_t station) const {
  const auto poses = static_cast<double>(last_[station] - first_[station]);
  return static_cast<std::uint64_t>(std::max(0.0, std::floor(1e-3 * setup_.rate_hz * poses) - 1.0));
}

std::uint64_t FrameTally::due() const {
  std::uint64_t due = 0;
  for (std::size_t i = 0; i < first_.size(); ++i) due += setup_.viewers * DueOf(i);
  return due;
}

std::uint64_t FrameTally::lost() const {
  std::uint64_t lost = 0;
  for (std::size_t i = 0; i < setup_.viewers * first_.size(); ++i) {
    const std::uint64_t due = DueOf(i % setup_.stations);
    lost += due - std::min(due, got_[i].frames);
  }
  return lost;
}

}  // namespace palpate
