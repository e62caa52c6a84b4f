#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

namespace palpate {

/// The connections that speak HTTP: bounded in all, and for each address from elsewhere.  When one
/// more comes, the one that has waited longest for a request makes room for it: nobody shuts others
/// out by holding connections open.
/// Thread contract: one thread.  Time is given [ns].
class Lobby {
 public:
  using Id = std::uint64_t;

  /// @param most_of_an_address  half of all, say: a class may share one, behind a router.
  Lobby(std::size_t most, std::size_t most_of_an_address)
      : most_(most), most_of_an_address_(most_of_an_address) {}

  /// Lets one in, which waits for its first request.  Nothing: there is no room, and all that could
  /// make it are being answered.
  /// @param address  empty: this host's own, which is not bounded apart.
  /// @param close    called at most once, where it has to make room.
  std::optional<Id> Enter(const std::string& address, std::function<void()> close,
                          std::int64_t now_ns);
  /// It waits for a request from now on.
  void Wait(Id id, std::int64_t now_ns);
  /// It is being answered, and stays.
  void Serve(Id id);
  void Leave(Id id) { guests_.erase(id); }

  std::size_t size() const { return guests_.size(); }

 private:
  struct Guest {
    std::string address;
    std::function<void()> close;
    std::optional<std::int64_t> waits_since_ns;
  };
  /// Room for one more of these; makes it where it can.
  bool MakeRoom(std::size_t most, const std::function<bool(const Guest&)>& counts);

  std::size_t most_;
  std::size_t most_of_an_address_;
  std::map<Id, Guest> guests_;
  Id last_ = 0;
};

}  // namespace palpate
