#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "common/dds/wire.h"
#include "server/session/cut_union.h"
#include "server/session/session.h"

namespace palpate {

/// A part of the log, ready to be published.  `sample.events` is empty; the events are in `events`.
struct CutLogNews {
  wire::CutLog sample{};
  std::vector<wire::CutEvent> events;
};

/// Takes from each session's loop the blocks that its bur changed, gives them to the loops of the
/// other sessions, and logs what a replay needs to do the same.  Loops never communicate directly:
/// the others feel a block that one cuts a poll or two later.
///
/// Thread contract: service thread.
class CutExchange {
 public:
  /// Called for each block whose content has changed.
  using Changed = std::function<void(std::uint32_t solid, std::uint32_t block)>;
  /// Number of samples that late recorders can still get.
  static constexpr std::uint32_t kSlots = 4096;

  /// `solids` must outlive this.
  explicit CutExchange(std::span<const CutSolid> solids) : union_(solids) {}

  const CutUnion& cuts() const { return union_; }
  /// Adds a session before its first pose, and gives it everything cut so far.
  void Begin(Session& session);
  /// Takes the blocks that a session's loop has told.
  void Take(Session& session, const Changed& changed);
  /// Gives a session's loop what others have changed, as far as there is room.
  void Give(Session& session);
  /// Removes a session to which no more poses can come.
  void End(Session& session, const Changed& changed);
  /// Call after MakeWhole of every session.
  void MakeWhole();
  void SetBookmark();
  /// Does MakeWhole; then everything in the bookmark waits to be given to every session.
  void GoBack();
  /// Returns whether the session has merged everything that waited for it.
  bool has_all(Session& session) const;

  /// Returns the log to publish now; the caller fills in scene and server.
  std::vector<CutLogNews> TakeLog(std::int64_t now_ns);

 private:
  /// Interval of the log while there is only one session: nobody else is given its cuts.
  static constexpr std::int64_t kTakenAlone_ns = 1'000'000'000;

  void Log(wire::CutStep step, std::uint32_t session, std::uint64_t count = 0,
           std::uint64_t pose_sequence = 0, std::uint64_t other = 0);

  CutUnion union_;
  std::map<const Session*, std::uint32_t> numbers_;
  std::uint32_t begun_ = 0;
  std::vector<CutLogNews> log_;
  std::uint64_t logged_ = 0;  // number of samples
  std::int64_t published_ns_ = 0;
};

}  // namespace palpate
