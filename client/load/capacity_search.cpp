#include "client/load/capacity_search.h"

#include <algorithm>

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

}  // namespace palpate
