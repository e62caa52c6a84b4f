#pragma once

#include <cstdint>
#include <optional>
#include <queue>
#include <utility>
#include <vector>

#include "tests/support/random.h"

namespace palpate::test {

/// The conditions of one direction of a link.
struct LinkConditions {
  std::int64_t delay_ns = 0;   ///< least transit time
  std::int64_t jitter_ns = 0;  ///< additional time, uniform from 0 to this; keeps the order
  double loss = 0.0;           ///< probability that a sample is lost; 1: the link is cut
  double duplication = 0.0;    ///< probability of a second arrival, up to `straggle_ns` later
  double reordering = 0.0;     ///< probability of being overtaken: a delay of up to `straggle_ns`
  std::int64_t straggle_ns = 5'000'000;
};

/// Draws the arrival times of the samples of a LossyWay, of any type.
///
/// Jitter queues samples, as a router does: a sample that is not reordered on purpose never
/// overtakes an earlier one, so `reordering` alone determines how much is out of order.  Pure: the
/// n-th result depends only on the seed, the conditions and the times given so far.
class LinkDice {
 public:
  explicit LinkDice(std::uint64_t seed) : random_(seed) {}

  struct Arrivals {
    int count = 0;  ///< 0 to 2
    std::int64_t time_ns[2] = {};
  };
  /// @param now_ns  not before that of the last call.
  Arrivals Send(std::int64_t now_ns, const LinkConditions& conditions);

 private:
  Random random_;
  std::int64_t queue_ends_ns_ = 0;  // the latest arrival among those in order
};

/// One direction of a link in virtual time: samples arrive when and as often as LinkDice says.
template <typename T>
class LossyWay {
 public:
  explicit LossyWay(std::uint64_t seed, const LinkConditions& conditions = {})
      : dice_(seed), conditions_(conditions) {}

  /// The conditions, which may be changed at any time; they apply to samples sent later.
  LinkConditions& conditions() { return conditions_; }

  void Send(std::int64_t now_ns, const T& sample) {
    const LinkDice::Arrivals arrivals = dice_.Send(now_ns, conditions_);
    for (int i = 0; i < arrivals.count; ++i) {
      under_way_.push({arrivals.time_ns[i], sent_++, sample});
    }
  }
  /// Returns the next sample that has arrived by `now_ns`, in order of arrival and then of sending.
  std::optional<T> Receive(std::int64_t now_ns) {
    if (under_way_.empty() || under_way_.top().time_ns > now_ns) return std::nullopt;
    T sample = under_way_.top().sample;
    under_way_.pop();
    return sample;
  }
  /// Returns the time of the next arrival, if any sample is in transit, for
  /// event-driven simulation.
  std::optional<std::int64_t> next_arrival_ns() const {
    if (under_way_.empty()) return std::nullopt;
    return under_way_.top().time_ns;
  }

 private:
  struct Packet {
    std::int64_t time_ns;
    std::uint64_t number;
    T sample;
    bool operator<(const Packet& other) const {  // the queue's top is its greatest
      return std::pair(time_ns, number) > std::pair(other.time_ns, other.number);
    }
  };
  LinkDice dice_;
  LinkConditions conditions_;
  std::priority_queue<Packet> under_way_;
  std::uint64_t sent_ = 0;
};

/// A link between a station and a server in virtual time: equal seeds and equal calls, equal bits.
template <typename Up, typename Down>
struct SimulatedLink {
  /// @param each_way  conditions of each direction; a round trip takes twice its delay.
  explicit SimulatedLink(std::uint64_t seed, const LinkConditions& each_way = {})
      : up(2 * seed, each_way), down(2 * seed + 1, each_way) {}
  LossyWay<Up> up;
  LossyWay<Down> down;
};

}  // namespace palpate::test
