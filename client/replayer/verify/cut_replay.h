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

/// What a server's cut log says about one session of a scene that burs cut.
struct CutFacts {
  std::uint32_t session = 0;                   ///< its number; 0: not in the log
  std::map<std::uint64_t, CutMerge> merges{};  ///< by pose
  /// Ranges of poses, [first, second), in which its loop had no room to report blocks.
  std::vector<std::pair<std::uint64_t, std::uint64_t>> held{};
  std::optional<wire::CutEvent> ended{};
  /// The merges are known up to this pose.
  std::uint64_t known = std::numeric_limits<std::uint64_t>::max();

  bool IsHeld(std::uint64_t pose_sequence) const;
};

/// The cut log of a scene in one run of a server, as far as it was recorded.
class CutLogFacts {
 public:
  void Add(const wire::CutLog& sample);
  /// Returns the facts of each session, by station and run.  Call it after the last Add.
  std::map<std::pair<std::string, std::uint64_t>, CutFacts> Sessions() const;
  /// Returns the events in order; none for each missing sample.
  std::vector<std::optional<wire::CutEvent>> Events() const;

 private:
  struct Sample {
    std::pair<std::string, std::uint64_t> begun;
    std::vector<wire::CutEvent> events;
  };
  std::map<std::uint64_t, Sample> samples_;  // by number
};

/// A session's part in the replay: the blocks that its loop reports, and those that it receives.
class CutSide {
 public:
  explicit CutSide(const CutFacts& facts) : facts_(facts) {}
  const CutFacts& facts() const { return facts_; }

  enum class Ready { kYes, kNotYet, kNever };
  /// Returns whether all blocks are there that its loop merges from this pose on.  For kNever,
  /// why() gives the reason.
  Ready IsReadyFor(std::uint64_t pose_sequence);
  /// Passes the blocks to the loop; call it before that pose.
  void Give(std::uint64_t pose_sequence, ServoLoop& loop);
  /// Takes the blocks that the loop reported; call it after the pose.
  void Take(ServoLoop& loop);
  const std::string& why() const { return why_; }

 private:
  friend class CutReplay;
  const CutFacts& facts_;
  bool begun_ = false;
  std::deque<CutBlock> published_, given_;
  std::uint64_t lost_ = 0;  // blocks up to this number will not come
  std::string why_;
};

/// A session that is recomputed.
class CutSession {
 public:
  virtual ~CutSession() = default;
  virtual CutSide& side() = 0;
  virtual ServoLoop& loop() = 0;
  virtual std::span<const CutSolid> solids() const = 0;
  /// True if no more of it will be computed.
  virtual bool is_done() const = 0;
  virtual std::uint64_t last_pose() const = 0;
  virtual const std::string& station() const = 0;
};

/// Repeats how a server shared what burs of a scene cut: takes blocks from the sessions' loops and
/// gives them to others, in the order of its log.  Each event waits until its session has reached
/// the same point.  This terminates, since every block was taken before it was given.
class CutReplay {
 public:
  /// @param open  returns a session, from its beginning, by its number in the log; null:
  ///              not recorded.
  CutReplay(std::vector<std::optional<wire::CutEvent>> events,
            std::function<CutSession*(std::uint32_t)> open)
      : events_(std::move(events)), open_(std::move(open)) {}

  /// Does as many events as possible now.  Returns true if it did any.
  bool Advance();
  /// Returns true if the session has reported all blocks and the log no longer needs it.
  bool IsOver(std::uint32_t session) const { return over_.contains(session); }
  /// Ends waiting at the end of the recording: blocks still missing will never come.
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
  std::optional<CutUnion> union_;  // made with the first recorded session
  std::string unknown_;            // why the union is not known; empty: it is
  std::string bookmark_unknown_;
  std::map<std::uint32_t, CutSession*> sessions_;
  std::map<std::uint32_t, std::uint64_t> given_;  // number of blocks, by session
  std::map<std::uint32_t, bool> over_;
};

}  // namespace palpate
