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

/// Counts the tool states that several viewers received between Begin() and End(), those that they
/// should have received, and their ages.
/// Thread contract: Add in one thread, Begin and End in another.  Read the results after the last
/// Add; frames() may be read at any time.
class FrameTally {
 public:
  struct Setup {
    std::size_t viewers = 0;
    std::size_t stations = 0;
    std::string name;       ///< stations are NAME_1, NAME_2, ...; frames of others are only counted
    double rate_hz = 30.0;  ///< rate of each station's frames
    /// Returns the sequence number of the newest pose sent by a station (from 0); 0: none yet.
    std::function<std::uint64_t(std::size_t station)> newest_sequence;
    /// Returns when a station sampled a pose [ns]; 0: too long ago to be remembered.
    std::function<std::int64_t(std::size_t station, std::uint64_t sequence)> sample_time_ns;
  };
  /// Age assumed for a frame that is older than its station remembers [ns]: a lower bound.
  static constexpr std::int64_t kForgotten_ns = 4'000'000'000;

  explicit FrameTally(Setup setup);

  void Begin(std::int64_t now_ns);
  void End(std::int64_t now_ns);
  /// Takes a frame that a viewer received at now_ns; counts it between Begin() and End().
  void Add(std::size_t viewer, const wire::ToolState& frame, std::int64_t now_ns);

  std::uint64_t frames() const { return frames_.load(std::memory_order_relaxed); }
  /// Returns the number of frames that all viewers should have received from all stations.  Poses
  /// are a millisecond apart, so at R frames per second a viewer should receive one frame for each
  /// 1000/R poses that the station has sent, less one that may be in flight.
  std::uint64_t due() const;
  /// Returns the number of due frames that were not received, summed over each viewer and station
  /// separately: a surplus of one does not make up for a loss of another.  A repeated pose does not
  /// count as received.
  std::uint64_t lost() const;
  /// Returns the ages, from the station's sample to the viewer [ns].
  const Histogram& age() const { return age_; }

 private:
  struct Got {
    std::uint64_t newest = 0;  // sequence
    std::uint64_t frames = 0;
  };
  /// Returns the station's index from 0; setup_.stations for a station that is not ours.
  std::size_t StationOf(const char* name) const;
  std::vector<std::uint64_t> NewestSequences() const;
  std::uint64_t DueOf(std::size_t station) const;

  static constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::max();

  Setup setup_;
  std::atomic<std::int64_t> begin_ns_{kNever_ns};
  std::atomic<std::int64_t> end_ns_{kNever_ns};
  // Of each station: newest sequence number at begin and end.
  std::vector<std::uint64_t> first_, last_;
  std::vector<Got> got_;  // [viewer * stations + station]
  std::atomic<std::uint64_t> frames_{0};
  Histogram age_;
};

}  // namespace palpate
