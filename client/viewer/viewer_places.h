#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace palpate {

/// The places of viewers: so many in all, shared out among addresses.  A fixed share of an address
/// would be too little for a class behind one router, and too much for one that opens sockets until
/// there are no more: so every address may have what nobody else wants, and where all places are
/// taken those of the address that has most make room for an address that has fewer.
/// An address that floods the gateway then shuts out nobody but itself.
/// Thread contract: one thread.  Time is given [ns].
class ViewerPlaces {
 public:
  using Id = std::uint64_t;
  /// Who has not subscribed to anything by then only sits there.
  static constexpr std::int64_t kIdle_ns = 5'000'000'000;

  explicit ViewerPlaces(std::size_t most) : most_(most) {}

  struct Room {
    bool is_there = false;
    std::optional<Id> leaves;  ///< whose place it is: that one goes now
  };
  /// Whether one more of this address may come.  Of those that can make room, the first are any
  /// that sit idle, longest first; then, of the address that has most, those that came last and
  /// hold no tool: a class that has looked on for an hour stays.
  Room RoomFor(const std::string& address, std::int64_t now_ns) const;

  void Enter(Id id, const std::string& address, std::int64_t now_ns);
  void Subscribed(Id id);
  /// It holds a tool, or has let it go.
  void Holds(Id id, bool holds);
  void Leave(Id id);

  std::size_t size() const { return guests_.size(); }

 private:
  struct Guest {
    std::string address;
    std::int64_t came_ns = 0;
    bool subscribed = false;
    bool holds = false;
  };
  std::size_t most_;
  std::map<Id, Guest> guests_;
  std::map<std::string, std::size_t> counts_;  // by address
};

}  // namespace palpate
