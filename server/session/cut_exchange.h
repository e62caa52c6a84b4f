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

/// A part of the log as it is to be published.  `sample.events` is empty: what it holds is in
/// `events`.
struct CutLogNews {
  wire::CutLog sample{};
  std::vector<wire::CutEvent> events;
};

/// Takes from each session's loop what its bur changed, gives it to the loops of the others, and
/// logs what a replay needs to do the same.  Loops never meet: a block that one cuts is felt by
/// the others a poll or two later.
///
/// Thread contract: service thread.
class CutExchange {
 public:
  /// Called for each block that is another than it was.
  using Changed = std::function<void(std::uint32_t solid, std::uint32_t block)>;
  /// Samples that late recorders may still get.
  static constexpr std::uint32_t kSlots = 4096;

  /// The solids outlive this.
  explicit CutExchange(std::span<const CutSolid> solids) : union_(solids) {}

  const CutUnion& cuts() const { return union_; }
  /// Before a session's first pose: it is given all, and is one of those that exchange.
  void Begin(Session& session);
  /// Takes what its loop has told.
  void Take(Session& session, const Changed& changed);
  /// Gives its loop what others have changed, as far as there is room.
  void Give(Session& session);
  /// No pose can come to it any more.
  void End(Session& session, const Changed& changed);
  /// To be called after every session's MakeWhole.
  void MakeWhole();
  void SetBookmark();
  /// As MakeWhole; then all that the bookmark has waits for every session.
  void GoBack();
  /// It has merged all that waited for it.
  bool has_all(Session& session) const;

  /// What is to be published now; scene and server are left to the caller.
  std::vector<CutLogNews> TakeLog(std::int64_t now_ns);

 private:
  /// What one bur alone cuts need not be told at once: nobody is given it.
  static constexpr std::int64_t kTakenAlone_ns = 1'000'000'000;

  void Log(wire::CutStep step, std::uint32_t session, std::uint64_t count = 0,
           std::uint64_t pose_sequence = 0, std::uint64_t other = 0);

  CutUnion union_;
  std::map<const Session*, std::uint32_t> numbers_;
  std::uint32_t begun_ = 0;
  std::vector<CutLogNews> log_;
  std::uint64_t logged_ = 0;  // samples
  std::int64_t published_ns_ = 0;
};

}  // namespace palpate
