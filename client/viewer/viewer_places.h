#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

namespace palpate {

/// Shares a fixed number of viewer places among addresses.  A fixed quota per address would be
/// too little for a class behind one router and too much for a client that opens sockets without
/// end.  So an address may use all free places; once none is free, an address with fewer viewers
/// gets a place from the address with the most.  An address that floods the gateway thus only
/// shuts out itself.
/// Thread contract: one thread.  Times are in nanoseconds.
class ViewerPlaces {
 public:
  using Id = std::uint64_t;
  /// A viewer that has not subscribed within this time counts as idle.
  static constexpr std::int64_t kIdle_ns = 5'000'000'000;

  explicit ViewerPlaces(std::size_t most) : most_(most) {}

  struct Room {
    bool is_there = false;
    std::optional<Id> leaves;  ///< whose place it is; that viewer must leave now
  };
  /// Returns whether one more viewer of this address may come.  If no place is free, it gets that
  /// of the viewer that has been idle longest, if any; else that of the latest viewer of the
  /// largest address, preferably one without a tool, if that address has at least two viewers more
  /// than this one.  So a class that has been watching for an hour stays.
  Room RoomFor(const std::string& address, std::int64_t now_ns) const;

  void Enter(Id id, const std::string& address, std::int64_t now_ns);
  void Subscribed(Id id);
  /// Takes note that a viewer took a tool or released it.
  void Holds(Id id, bool holds);
  void Leave(Id id);

  std::size_t size() const { return guests_.size(); }
  std::size_t most() const { return most_; }

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
