#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/wire.h"
#include "server/session/cut_union.h"
#include "server/session/servo_loop.h"

namespace palpate {

/// What a server's log says of one session of a scene that burs cut.
struct CutFacts {
  std::uint32_t session = 0;                   ///< its number; 0: the log does not know it
  std::map<std::uint64_t, CutMerge> merges{};  ///< by pose
  /// Poses at which its loop had no room to tell blocks: from, and before.
  std::vector<std::pair<std::uint64_t, std::uint64_t>> held{};
  std::optional<wire::CutEvent> ended{};
  /// What it merged is known up to this pose.
  std::uint64_t known = std::numeric_limits<std::uint64_t>::max();

  bool IsHeld(std::uint64_t pose_sequence) const;
};

/// The log of a scene in one run of a server, as far as it was recorded.
class CutLogFacts {
 public:
  void Add(const wire::CutLog& sample);
  /// After all: what it says of each session, by station and run.
  std::map<std::pair<std::string, std::uint64_t>, CutFacts> Sessions() const;
  /// In their order; none where samples are missing.
  std::vector<std::optional<wire::CutEvent>> Events() const;

 private:
  struct Sample {
    std::pair<std::string, std::uint64_t> begun;
    std::vector<wire::CutEvent> events;
  };
  std::map<std::uint64_t, Sample> samples_;  // by number
};

/// A session's part in it: what its loop tells, and what it is given.
class CutSide {
 public:
  explicit CutSide(const CutFacts& facts) : facts_(facts) {}
  const CutFacts& facts() const { return facts_; }

  enum class Ready { kYes, kNotYet, kNever };
  /// Whether all is there that its loop merges from this pose on.  kNever: why().
  Ready IsReadyFor(std::uint64_t pose_sequence);
  /// Gives it to the loop, before that pose.
  void Give(std::uint64_t pose_sequence, ServoLoop& loop);
  /// Takes what the loop told, after it.
  void Take(ServoLoop& loop);
  const std::string& why() const { return why_; }

 private:
  friend class CutReplay;
  const CutFacts& facts_;
  bool begun_ = false;
  std::deque<CutBlock> told_, given_;
  std::uint64_t lost_ = 0;  // blocks up to this number will not come
  std::string why_;
};

/// A session that is computed again.
class CutSession {
 public:
  virtual ~CutSession() = default;
  virtual CutSide& side() = 0;
  virtual ServoLoop& loop() = 0;
  virtual std::span<const CutSolid> solids() const = 0;
  /// No more of it will be computed; and the last pose that was.
  virtual bool is_done() const = 0;
  virtual std::uint64_t last_pose() const = 0;
  virtual const std::string& station() const = 0;
};

/// Does again what a server did with what burs of a scene cut: takes blocks from the sessions'
/// loops and gives them to others, in the order of its log.  Each event waits until the session has
/// come to where it was then; that ends, since what was given had been taken before.
class CutReplay {
 public:
  /// @param open  a session by its number in the log, from the beginning; null: it is not recorded.
  CutReplay(std::vector<std::optional<wire::CutEvent>> events,
            std::function<CutSession*(std::uint32_t)> open)
      : events_(std::move(events)), open_(std::move(open)) {}

  /// As many events as can be done now.  True where any was.
  bool Advance();
  /// The session has told all that it will, and the log needs it no more.
  bool IsOver(std::uint32_t session) const { return over_.contains(session); }
  /// The recording is at its end: who still waits for blocks waits in vain.
  void GiveUp();

 private:
  bool Do(const wire::CutEvent& event);
  void Begin(const wire::CutEvent& event);
  bool Take(const wire::CutEvent& event);
  void Give(const wire::CutEvent& event);
  bool End(const wire::CutEvent& event);
  void Lose(const std::string& why) {
    if (unknown_.empty()) unknown_ = why;
  }
  CutSession* Find(std::uint32_t session) const;

  std::vector<std::optional<wire::CutEvent>> events_;
  std::size_t next_ = 0;
  std::function<CutSession*(std::uint32_t)> open_;
  std::optional<CutUnion> union_;  // with the first that is recorded
  std::string unknown_;            // why what there is is not known; empty: it is
  std::string bookmark_unknown_;
  std::map<std::uint32_t, CutSession*> sessions_;
  std::map<std::uint32_t, std::uint64_t> given_;  // blocks, by session
  std::map<std::uint32_t, bool> over_;
};

}  // namespace palpate
