#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "common/dds/wire.h"
#include "common/realtime/histogram.h"

namespace palpate {

/// What several viewers have got from Begin() to End(): tool states, how many more were due, and
/// how old they were.
/// Thread contract: Add in one thread, Begin and End in another; what is counted is read when no
/// more is added, but frames(), which may be read at any time.
class FrameTally {
 public:
  struct Setup {
    std::size_t viewers = 0;
    std::size_t stations = 0;
    std::string name;       ///< stations are NAME_1, NAME_2, ...; others' frames only count
    double rate_hz = 30.0;  ///< at which each station's frames come
    /// The newest pose that a station (from 0) has sent; 0: none yet.
    std::function<std::uint64_t(std::size_t station)> newest_sequence;
    /// When a station sampled a pose [ns]; 0: too long ago to be remembered.
    std::function<std::int64_t(std::size_t station, std::uint64_t sequence)> sample_time_ns;
  };
  /// What a frame counts as that is older than its station remembers [ns]: at least so old.
  static constexpr std::int64_t kForgotten_ns = 4'000'000'000;

  explicit FrameTally(Setup setup);

  void Begin(std::int64_t now_ns);
  void End(std::int64_t now_ns);
  /// A frame that a viewer got at a time; counted from Begin() to End().
  void Add(std::size_t viewer, const wire::ToolState& frame, std::int64_t now_ns);

  std::uint64_t frames() const { return frames_.load(std::memory_order_relaxed); }
  /// That all viewers should have got of all stations: poses are a millisecond apart, so a viewer's
  /// frames at R a second are one for each 1000/R poses that the station has sent; of which one
  /// less, as it may be on its way.
  std::uint64_t due() const;
  /// Those of them that a viewer did not get, each viewer and station by itself: more of one do not
  /// make good for less of another.  A pose that is shown again is no frame got.
  std::uint64_t lost() const;
  /// From the station's sample to the viewer [ns].
  const Histogram& age() const { return age_; }

 private:
  struct Got {
    std::uint64_t newest = 0;  // sequence
    std::uint64_t frames = 0;
  };
  /// From 0; setup_.stations for what is none of ours.
  std::size_t StationOf(const char* name) const;
  std::vector<std::uint64_t> NewestSequences() const;
  std::uint64_t DueOf(std::size_t station) const;

  static constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::max();

  Setup setup_;
  std::atomic<std::int64_t> begin_ns_{kNever_ns};
  std::atomic<std::int64_t> end_ns_{kNever_ns};
  std::vector<std::uint64_t> first_, last_;  // of each station: newest sequence at begin and end
  std::vector<Got> got_;                     // [viewer * stations + station]
  std::atomic<std::uint64_t> frames_{0};
  Histogram age_;
};

}  // namespace palpate
