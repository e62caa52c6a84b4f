#include "client/load/frame_tally.h"

#include <charconv>
#include <string_view>

namespace palpate {

FrameTally::FrameTally(Setup setup)
    : setup_(std::move(setup)), newest_(setup_.viewers * setup_.stations, 0) {}

std::size_t FrameTally::StationOf(const char* name) const {
  const std::string_view text(name);
  const std::string& ours = setup_.name;
  if (!text.starts_with(ours) || text.size() < ours.size() + 2 || text[ours.size()] != '_') {
    return setup_.stations;
  }
  std::size_t number = 0;
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data() + ours.size() + 1, end, number);
  const bool one_of_ours =
      error == std::errc() && at == end && number >= 1 && number <= setup_.stations;
  return one_of_ours ? number - 1 : setup_.stations;
}

void FrameTally::Add(std::size_t viewer, const wire::ToolState& frame, std::int64_t now_ns) {
  const bool counts = now_ns >= begin_ns_.load(std::memory_order_relaxed);
  if (counts) frames_.fetch_add(1, std::memory_order_relaxed);
  const std::size_t station = StationOf(frame.station);
  if (station == setup_.stations) return;
  std::uint64_t& newest = newest_[viewer * setup_.stations + station];
  if (counts && newest != 0 && frame.pose_sequence > newest) {
    const double frames = 1e-3 * setup_.rate_hz * static_cast<double>(frame.pose_sequence - newest);
    if (frames >= 2.0) lost_ += static_cast<std::uint64_t>(frames) - 1;
  }
  newest = frame.pose_sequence;
  if (!counts) return;
  const std::int64_t sampled_ns = setup_.sample_time_ns(station, frame.pose_sequence);
  if (sampled_ns != 0) age_.Add(now_ns - sampled_ns);
}

}  // namespace palpate
