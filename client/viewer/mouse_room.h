#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "client/viewer/mouse_command.h"
#include "client/viewer/mouse_station.h"
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
    /// Of the stations' names, before their numbers; no other station of the domain has it.
    std::string prefix = "mouse_";
  };
  /// What became of a viewer's mouse: `phase` is "waiting", "acquiring", "active", "refused",
  /// "ended" or "held", as in SessionState; empty while there is no answer.
  struct News {
    Holder holder = 0;
    std::string station, scene, tool, phase, reason;
  };

  MouseRoom(Options options, std::function<void(const News&)> tell)
      : options_(std::move(options)), tell_(std::move(tell)) {}

  /// @param scene_known  false: there is no such scene, or no server.
  void Take(Holder holder, const MouseCommand& command, bool scene_known, std::int64_t now_ns);
  /// Of no effect where the viewer holds nothing: poses may come late, after a release.
  void Drag(Holder holder, const Pose& X_WT, std::int64_t now_ns);
  /// Also when the viewer has gone.
  void Release(Holder holder, const std::string& reason, std::int64_t now_ns);
  bool holds(Holder holder) const { return Find(holder) != nullptr; }

  void OnSession(const wire::SessionState& state, std::int64_t now_ns);
  /// Looks after the stations, some 100 times a second.
  void Poll(std::int64_t now_ns);
  /// Stations that run, or are about to.
  std::size_t size() const { return mice_.size(); }

 private:
  struct Mouse {
    std::unique_ptr<MouseStation> station;  // null: it is started once its tool is free
    Holder holder = 0;                      // 0: let go, and on its way out
    std::string scene, tool;
    std::uint64_t run = 0;  // of its session; 0: it never had one
    std::int64_t moved_ns = 0;
    bool held = false;  // until a teacher admits it: nobody can move it
  };
  const Mouse* Find(Holder holder) const;
  std::string NameOf(int number) const { return options_.prefix + std::to_string(number); }
  /// The tool is still in the hand of a mouse that is on its way out.
  bool StillHeld(const Mouse& wanted) const;
  void Start(int number, Mouse& mouse, std::int64_t now_ns);
  void LetGo(int number, Mouse& mouse, const std::string& phase, const std::string& reason,
             std::int64_t now_ns);

  Options options_;
  std::function<void(const News&)> tell_;
  std::map<int, Mouse> mice_;  // by the number in the station's name, from 1
};

}  // namespace palpate
