#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_set>

namespace palpate {

/// Which requests have been heard, so that none is done twice: a writer that has been out of reach
/// is asked for its last one again when it comes back, and whoever could replay one would have it
/// done anew.  The newest kMost are remembered, far more than people ask for in a day.
/// Thread contract: one thread.
class RequestMemory {
 public:
  static constexpr std::size_t kMost = 4096;

  /// @param request  its random number.   True the first time that it is heard.
  bool IsNew(std::uint64_t request) {
    if (!heard_.insert(request).second) return false;
    order_.push_back(request);
    if (order_.size() > kMost) {
      heard_.erase(order_.front());
      order_.pop_front();
    }
    return true;
  }

 private:
  std::unordered_set<std::uint64_t> heard_;
  std::deque<std::uint64_t> order_;  // oldest first
};

}  // namespace palpate
