#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>

#include "client/viewer/mouse_station.h"
#include "client/viewer/page_messages.h"
#include "common/dds/network.h"
#include "common/dds/wire.h"

namespace palpate {

/// The tools that viewers hold with the mouse: a station for each, and what its viewer is told of
/// it.  A viewer holds one at a time.
/// Thread contract: one thread.  Time is given [ns].
class MouseRoom {
 public:
  /// A tool that nobody moves for so long is free for others.
  static constexpr std::int64_t kIdle_ns = 300'000'000'000;

  using Holder = std::uint64_t;  ///< a viewer
  struct Options {
    int most = 4;
    int domain = 0;
    std::string transport = "auto";
    dds::Network network;
    std::string program;  ///< path of palpate-station
    /// Of the stations of those who have no name, before their numbers; no other station of the
    /// domain has it.
    std::string prefix = "mouse_";
    /// Before the names of those who have one.
    std::string named_prefix = "";
    /// Whether a name is another's: (the station's, whose it is to be).
    std::function<bool(const std::string& station, const std::string& who)> is_others =
        [](const std::string&, const std::string&) { return false; };
  };
  /// What became of a viewer's mouse: `phase` is "waiting", "acquiring", "active", "refused",
  /// "ended" or "held", as in SessionState; empty while there is no answer.
  struct News {
    Holder holder = 0;
    std::string station, scene, tool, phase, reason;
  };

  MouseRoom(Options options, std::function<void(const News&)> tell)
      : options_(std::move(options)), tell_(std::move(tell)) {}

  /// @param who        the name of the viewer's token, which becomes its station's; empty: it has
  ///                   none.   @param absent  why the scene cannot be had now; empty: it can.
  /// @param waits      its station is started by Go, once a recorder is there.
  /// Returns the station's name; empty: it is refused.
  std::string Take(Holder holder, const std::string& who, const MouseCommand& command,
                   const std::string& absent, std::int64_t now_ns, bool waits = false);
  void Go(Holder holder, std::int64_t now_ns);
  /// Of no effect where the viewer holds nothing: poses may come late, after a release.
  void Drag(Holder holder, const Pose& X_WT, std::int64_t now_ns);
  /// Also when the viewer has gone.
  void Release(Holder holder, const std::string& reason, std::int64_t now_ns);
  bool holds(Holder holder) { return Find(holder) != nullptr; }
  /// Another holder has a tool of that scene.  @param tool  that one; empty: any.
  bool IsTaken(const std::string& scene, const std::string& tool, Holder holder) const;

  void OnSession(const wire::SessionState& state, std::int64_t now_ns);
  /// Looks after the stations, some 100 times a second.
  void Poll(std::int64_t now_ns);
  const std::string& named_prefix() const { return options_.named_prefix; }
  /// Stations that run, or are about to.
  std::size_t size() const { return mice_.size(); }

 private:
  struct Mouse {
    std::string name;                       // of its station
    std::unique_ptr<MouseStation> station;  // null: it is started once its tool is free
    Holder holder = 0;                      // 0: let go, and on its way out
    std::string scene, tool;
    std::uint64_t run = 0;  // of its session; 0: it never had one
    std::int64_t moved_ns = 0;
    bool waits = false;     // until Go
    bool recorded = false;  // its station waits for the recorder's reader
    bool held = false;      // until a teacher admits it: nobody can move it
  };
  Mouse* Find(Holder holder);
  /// A station's name that nobody has: anna, anna_2, ...; without a name mouse_1, mouse_2, ... That
  /// of a mouse on its way out is free for the one that waits for its tool.
  std::string NameFor(const std::string& who, const Mouse& wanted) const;
  /// The tool is still in the hand of this mouse, which is on its way out.
  static bool Leaves(const Mouse& mouse, const Mouse& wanted);
  bool StillHeld(const Mouse& wanted) const;
  void Start(Mouse& mouse, std::int64_t now_ns);
  void LetGo(Mouse& mouse, const std::string& phase, const std::string& reason,
             std::int64_t now_ns);

  Options options_;
  std::function<void(const News&)> tell_;
  std::list<Mouse> mice_;  // in the order in which they came
};

}  // namespace palpate
