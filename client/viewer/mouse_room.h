#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "client/viewer/mouse_command.h"
#include "client/viewer/mouse_station.h"
#include "common/dds/wire.h"

namespace palpate {

/// The tools that viewers hold with the mouse: a station for each, and what its viewer is told of
/// it.  A viewer holds one at a time.
/// Thread contract: one thread.
class MouseRoom {
 public:
  using Holder = std::uint64_t;  ///< a viewer
  struct Options {
    int most = 4;
    int domain = 0;
    std::string transport = "auto";
    std::string program;  ///< path of palpate-station
  };
  /// What became of a viewer's mouse: `phase` is "waiting", "acquiring", "active", "refused" or
  /// "ended", as in SessionState; empty while there is no answer.
  struct News {
    Holder holder = 0;
    std::string station, scene, tool, phase, reason;
  };

  MouseRoom(Options options, std::function<void(const News&)> tell)
      : options_(std::move(options)), tell_(std::move(tell)) {}

  /// @param scene_known  false: there is no such scene, or no server.
  void Take(Holder holder, const MouseCommand& command, bool scene_known);
  /// False where the viewer holds nothing.
  bool Drag(Holder holder, const Pose& X_WT);
  /// Also when the viewer has gone.
  void Release(Holder holder, const std::string& reason, std::int64_t now_ns);
  bool holds(Holder holder) const { return Find(holder) != nullptr; }

  void OnSession(const wire::SessionState& state, std::int64_t now_ns);
  /// Looks after the stations, some 100 times a second.
  void Poll(std::int64_t now_ns);
  /// Stations that run.
  std::size_t size() const { return mice_.size(); }

 private:
  struct Mouse {
    std::unique_ptr<MouseStation> station;
    Holder holder = 0;  // 0: let go, and on its way out
    std::string scene, tool;
  };
  const Mouse* Find(Holder holder) const;
  static std::string NameOf(int number) { return "mouse_" + std::to_string(number); }
  void LetGo(int number, Mouse& mouse, const std::string& phase, const std::string& reason,
             std::int64_t now_ns);

  Options options_;
  std::function<void(const News&)> tell_;
  std::map<int, Mouse> mice_;  // by the number in the station's name, from 1
};

}  // namespace palpate
