#include "client/viewer/viewer_places.h"

#include <algorithm>

namespace palpate {

ViewerPlaces::Room ViewerPlaces::RoomFor(const std::string& address, std::int64_t now_ns) const {
  if (guests_.size() < most_) return {true, std::nullopt};
  // In the order of ids, that is of arrival.
  for (const auto& [id, guest] : guests_) {
    if (!guest.subscribed && now_ns - guest.came_ns > kIdle_ns) return {true, id};
  }
  const auto largest =
      std::ranges::max_element(counts_, {}, [](const auto& entry) { return entry.second; });
  const auto own = counts_.find(address);
  const std::size_t has = own == counts_.end() ? 0 : own->second;
  // Moving a place must not merely swap the two addresses' roles.
  if (largest == counts_.end() || largest->second <= has + 1) return {};
  std::optional<Id> last, last_that_holds;
  for (const auto& [id, guest] : guests_) {
    if (guest.address != largest->first) continue;
    (guest.holds ? last_that_holds : last) = id;
  }
  return {true, last ? last : last_that_holds};
}

void ViewerPlaces::Enter(Id id, const std::string& address, std::int64_t now_ns) {
  guests_[id] = {address, now_ns};
  ++counts_[address];
}

void ViewerPlaces::Subscribed(Id id) {
  if (const auto guest = guests_.find(id); guest != guests_.end()) guest->second.subscribed = true;
}

void ViewerPlaces::Holds(Id id, bool holds) {
  if (const auto guest = guests_.find(id); guest != guests_.end()) guest->second.holds = holds;
}

void ViewerPlaces::Leave(Id id) {
  const auto guest = guests_.find(id);
  if (guest == guests_.end()) return;
  const auto count = counts_.find(guest->second.address);
  if (--count->second == 0) counts_.erase(count);
  guests_.erase(guest);
}

}  // namespace palpate
