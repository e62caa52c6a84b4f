#include "common/http/lobby.h"

#include <utility>

namespace palpate {

bool Lobby::MakeRoom(std::size_t most, const std::function<bool(const Guest&)>& counts) {
  std::size_t here = 0;
  auto longest = guests_.end();
  for (auto it = guests_.begin(); it != guests_.end(); ++it) {
    const Guest& guest = it->second;
    if (!counts(guest)) continue;
    ++here;
    if (guest.waits_since_ns &&
        (longest == guests_.end() || *guest.waits_since_ns < *longest->second.waits_since_ns)) {
      longest = it;
    }
  }
  if (here < most) return true;
  if (longest == guests_.end()) return false;
  const auto close = std::move(longest->second.close);
  guests_.erase(longest);
  close();
  return true;
}

std::optional<Lobby::Id> Lobby::Enter(const std::string& address, std::function<void()> close,
                                      std::int64_t now_ns) {
  if (!address.empty() && !MakeRoom(most_of_an_address_,
                                    [&](const Guest& guest) { return guest.address == address; })) {
    return std::nullopt;
  }
  if (!MakeRoom(most_, [](const Guest&) { return true; })) return std::nullopt;
  guests_[++last_] = {address, std::move(close), now_ns};
  return last_;
}

void Lobby::Wait(Id id, std::int64_t now_ns) {
  if (const auto guest = guests_.find(id); guest != guests_.end()) {
    guest->second.waits_since_ns = now_ns;
  }
}

void Lobby::Serve(Id id) {
  if (const auto guest = guests_.find(id); guest != guests_.end()) {
    guest->second.waits_since_ns.reset();
  }
}

}  // namespace palpate
