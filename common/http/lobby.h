#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

namespace palpate {

/// The HTTP connections of a server, limited in total and per remote address.  A newcomer displaces
/// the connection that has waited longest for a request, so that nobody can lock others out by
/// holding connections open.
/// Thread contract: one thread.  The caller passes the time [ns].
class Lobby {
 public:
  using Id = std::uint64_t;

  /// @param most_of_an_address  limit per remote address.  Half of all, say: a class behind a
  /// router shares one address.
  Lobby(std::size_t most, std::size_t most_of_an_address)
      : most_(most), most_of_an_address_(most_of_an_address) {}

  /// Admits a connection, which then waits for its first request.  Returns nothing if there is no
  /// room and every connection that could be displaced is being answered.
  /// @param address  empty: this host's own, which has no limit of its own.
  /// @param close    called at most once, when the connection is displaced.
  std::optional<Id> Enter(const std::string& address, std::function<void()> close,
                          std::int64_t now_ns);
  /// Marks a connection as waiting for a request from now on.
  void Wait(Id id, std::int64_t now_ns);
  /// Marks a connection as being answered, so that it is not displaced.
  void Serve(Id id);
  void Leave(Id id) { guests_.erase(id); }

  std::size_t size() const { return guests_.size(); }

 private:
  struct Guest {
    std::string address;
    std::function<void()> close;
    std::optional<std::int64_t> waits_since_ns;
  };
  /// Ensures room for one more of those that `counts` selects, by displacing one; false if
  /// it cannot.
  bool MakeRoom(std::size_t most, const std::function<bool(const Guest&)>& counts);

  std::size_t most_;
  std::size_t most_of_an_address_;
  std::map<Id, Guest> guests_;
  Id last_ = 0;
};

}  // namespace palpate
