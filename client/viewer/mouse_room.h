#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>

#include "client/viewer/frame_queue.h"
#include "client/viewer/mouse_station.h"
#include "client/viewer/page_messages.h"
#include "common/dds/network.h"
#include "common/dds/wire.h"

namespace palpate {

/// The tools that viewers hold with the mouse: runs a station for each, and reports its state to
/// the viewer.  A viewer holds one tool at a time.
/// Thread contract: one thread.  Times are in nanoseconds.
class MouseRoom {
 public:
  using Holder = std::uint64_t;  ///< a viewer
  struct Options {
    int most = 4;
    int domain = 0;
    std::string transport = "auto";
    dds::Network network;
    std::string program;  ///< path of palpate-station
    /// Prefix of the numbered station names of viewers without a name; no other station of the
    /// domain may use it.
    std::string prefix = "mouse_";
    /// Prefix of the station names of viewers with a name.
    std::string named_prefix = "";
    /// Returns whether a station name is taken by, or reserved for, somebody whose own is not
    /// `who`.
    std::function<bool(const std::string& station, const std::string& who)> is_others =
        [](const std::string&, const std::string&) { return false; };
    /// Returns the viewer's name, for the log; empty: it has none.
    std::function<std::string(Holder)> name_of = [](Holder) { return ""; };
  };
  /// A change of a viewer's mouse.  `phase` is "waiting", "acquiring", "active", "refused", "ended"
  /// or "held", as in SessionState; empty before the first answer.
  struct News {
    Holder holder = 0;
    std::string station, scene, tool, phase, reason;
    bool lost = false;  ///< it ended because its viewer did not come back
  };

  MouseRoom(Options options, std::function<void(const News&)> tell)
      : options_(std::move(options)), tell_(std::move(tell)) {}

  /// Takes a tool for a viewer.  Returns the station's name; empty: it is refused.
  /// @param who        station of the viewer's token, which is numbered; empty: it has none.
  /// @param absent     why the scene is not available now; empty: it is.
  /// @param waits      the station starts only after Go, when a recorder is there.
  std::string Take(Holder holder, const std::string& who, const MouseCommand& command,
                   const std::string& absent, std::int64_t now_ns, bool waits = false);
  void Go(Holder holder, std::int64_t now_ns);
  /// Has no effect if the viewer holds nothing: poses may arrive after a release.
  void Drag(Holder holder, const Pose& X_WT, bool still, std::int64_t now_ns);
  /// Also to be called when the viewer has gone.   @param holder  0: everybody
  void Release(Holder holder, const std::string& reason, std::int64_t now_ns);
  /// Its viewer is missing: the tool rests where it is, without force, until Return or for
  /// ViewerLimits::kMouseAway_ns.
  void Rest(Holder holder, std::int64_t now_ns);
  /// Gives a resting tool to the viewer that has come in place of `holder`, or is that one again.
  /// Returns false if there is none.
  bool Return(Holder holder, Holder to, std::int64_t now_ns);
  bool holds(Holder holder) const { return !StationOf(holder).empty(); }
  /// Returns the station of the tool that a viewer holds; empty: it holds none.
  std::string StationOf(Holder holder) const;
  /// Returns whether another holder has that tool of the scene.  @param tool  empty: any.
  bool IsTaken(const std::string& scene, const std::string& tool, Holder holder) const;

  void OnSession(const wire::SessionState& state, std::int64_t now_ns);
  /// Advances the stations; to be called some 100 times a second.
  void Poll(std::int64_t now_ns);
  /// Number of stations that run or are about to.
  std::size_t size() const { return mice_.size(); }

 private:
  struct Mouse {
    std::string name;                       // of its station
    std::string logged;                     // that name and its holder's
    std::unique_ptr<MouseStation> station;  // null: it is started once its tool is free
    Holder holder = 0;                      // 0: released, and ending
    std::string scene, tool;
    std::uint64_t run = 0;  // of its session; 0: it has not had one
    std::int64_t moved_ns = 0;
    std::int64_t away_ns = 0;  // since when its viewer is missing; 0: it is there
    std::string phase;
    bool waits = false;     // until Go
    bool recorded = false;  // its station waits for a recorder to subscribe
    bool held = false;      // a teacher has not admitted it yet: it cannot be moved
  };
  Mouse* Find(Holder holder);
  /// Returns a station name that is free: anna, anna_2, ...; without a name mouse_1, mouse_2, ...
  /// The name of an ending mouse is free for the mouse that waits for its tool.
  std::string NameFor(const std::string& who, const Mouse& wanted) const;
  /// Returns whether `mouse` is ending but still holds the tool that `wanted` is to have.
  static bool Leaves(const Mouse& mouse, const Mouse& wanted);
  bool StillHeld(const Mouse& wanted) const;
  void Start(Mouse& mouse, std::int64_t now_ns);
  void LetGo(Mouse& mouse, const std::string& phase, const std::string& reason, std::int64_t now_ns,
             bool lost = false);

  Options options_;
  std::function<void(const News&)> tell_;
  std::list<Mouse> mice_;  // in order of arrival
};

/// Returns the frame that tells a viewer the state of its mouse.
FramePtr MouseStateFrame(const MouseRoom::News& news);

}  // namespace palpate
