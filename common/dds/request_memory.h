#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <unordered_set>

namespace palpate {

/// Remembers the requests that have been received, so that none is executed twice: a writer that
/// was unreachable sends its last one again when it comes back, and an attacker could replay one.
/// Keeps the newest kMost, far more than people send in a day.
/// Thread contract: one thread.
class RequestMemory {
 public:
  static constexpr std::size_t kMost = 4096;

  /// @param request  its random number.
  /// Returns true the first time that this request is received.
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
