#pragma once

#include <cstddef>
#include <functional>

namespace palpate {

/// A largest load.
struct Capacity {
  std::size_t holds = 0;  ///< 0: not even one
  /// The least that was seen not to hold; 0: all there was to try held.
  std::size_t fails = 0;
};

/// The largest n of 1 to `most` that holds, where what is less than that holds, too: by doubling,
/// then bisection.  A load that does not hold is tried `attempts` times, because a machine that had
/// something else to do for a moment says no more than that.
/// @param holds  runs a load; what it throws comes through.
Capacity FindCapacity(std::size_t most, int attempts,
                      const std::function<bool(std::size_t n)>& holds);

}  // namespace palpate
