#include "client/load/capacity_search.h"

#include <algorithm>
#include <cstdint>
#include <map>

#include "common/error.h"

namespace palpate {

Capacity FindCapacity(std::size_t most, int attempts,
                      const std::function<bool(std::size_t n)>& holds) {
  const auto holds_once = [&](std::size_t n) {
    for (int i = 0; i < attempts; ++i) {
      if (holds(n)) return true;
    }
    return false;
  };
  Capacity capacity;
  for (std::size_t n = 1; capacity.holds < most && capacity.fails == 0; n *= 2) {
    n = std::min(n, most);
    (holds_once(n) ? capacity.holds : capacity.fails) = n;
  }
  while (capacity.fails > capacity.holds + 1) {
    const std::size_t middle = capacity.holds + (capacity.fails - capacity.holds) / 2;
    (holds_once(middle) ? capacity.holds : capacity.fails) = middle;
  }
  return capacity;
}

FoundLoad FindLoad(std::size_t most, int attempts,
                   const std::function<std::optional<LoadFigures>(std::size_t n)>& run) {
  FoundLoad found;
  // By number: the last that failed may have held at its second attempt.
  std::map<std::size_t, LoadFigures> failed;
  std::size_t refused = SIZE_MAX;
  found.capacity = FindCapacity(most, attempts, [&](std::size_t n) {
    if (n >= refused) return false;
    try {
      const auto figures = run(n);
      if (!figures) return false;
      if (Holds(*figures)) {
        found.held = figures;
        return true;
      }
      failed.insert_or_assign(n, *figures);
    } catch (const Error& error) {
      // Where less has worked, server and gateway are there.
      if (!found.held) throw;
      refused = n;
      found.refusal = error.what();
    }
    return false;
  });
  if (found.capacity.fails == refused) return found;
  found.refusal.clear();
  const auto least = failed.find(found.capacity.fails);
  if (least != failed.end()) found.failed = least->second;
  return found;
}

}  // namespace palpate
