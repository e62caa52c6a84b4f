#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "common/dds/wire.h"
#include "common/stats/histogram.h"

namespace palpate {

/// What several viewers have got: tool states, those that are missing, and how old they were.
/// Thread contract: Add in one thread; what it counts is read when that thread adds no more, but
/// frames(), which may be read at any time.
class FrameTally {
 public:
  struct Setup {
    std::size_t viewers = 0;
    std::size_t stations = 0;
    std::string name;       ///< stations are NAME_1, NAME_2, ...; others' frames only count
    double rate_hz = 30.0;  ///< at which each station's frames come
    /// When a station (from 0) sampled a pose [ns]; 0: nobody knows.
    std::function<std::int64_t(std::size_t station, std::uint64_t sequence)> sample_time_ns;
  };
  explicit FrameTally(Setup setup);

  /// A frame that a viewer got; before Begin() it counts for nothing but the gap to the next.
  void Add(std::size_t viewer, const wire::ToolState& frame, std::int64_t now_ns);
  void Begin(std::int64_t now_ns) { begin_ns_.store(now_ns, std::memory_order_relaxed); }

  std::uint64_t frames() const { return frames_.load(std::memory_order_relaxed); }
  /// Poses are a millisecond apart, so a station's frames at R a second are 1000/R poses apart, and
  /// up to a frame of the server's more, as theirs are not at the same times.  A gap of n times
  /// that is n - 1 frames lost.
  std::uint64_t lost() const { return lost_; }
  /// From the station's sample to the viewer [ns].
  const Histogram& age() const { return age_; }

 private:
  /// From 0; setup_.stations for what is none of ours.
  std::size_t StationOf(const char* name) const;

  Setup setup_;
  std::atomic<std::int64_t> begin_ns_{INT64_MAX};
  std::vector<std::uint64_t> newest_;  // [viewer * stations + station]: sequence
  std::atomic<std::uint64_t> frames_{0};
  std::uint64_t lost_ = 0;
  Histogram age_;
};

}  // namespace palpate
