#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <vector>

#include "scenes/grid/cut_field.h"
#include "server/physics/cut/cutting.h"
#include "server/session/cut_block.h"

namespace palpate {

/// Everything that all burs of a scene have removed from its solids, and which sessions have not
/// been given all of it yet.  Depends on the calls alone: the same calls in the same order give the
/// same blocks with the same bits.
class CutUnion {
 public:
  /// `solids` must outlive this.  Throws Error if their fields do not fit into memory.
  explicit CutUnion(std::span<const CutSolid> solids);

  const std::vector<CutField>& cuts() const { return cuts_; }
  bool is_whole() const { return whole_; }
  /// Adds a session.  If `has_all`, it has everything so far and only later cuts of others wait for
  /// it; otherwise it begins with nothing, and everything waits.
  void Join(std::uint32_t session, bool has_all);
  void Leave(std::uint32_t session) { waiting_.erase(session); }
  /// Merges a block that a session's bur has changed.  Returns whether that changed anything.
  bool Take(std::uint32_t session, const CutBlock& block);
  /// Takes the next block that a session is to be given, with its current content.  Returns
  /// false if none waits.
  bool Give(std::uint32_t session, CutBlock& block);
  bool has_all(std::uint32_t session) const { return waiting_.at(session).line.empty(); }
  /// Restores all material for all sessions.
  void MakeWhole();
  /// Stores the current state as the bookmark, replacing an earlier one.
  void SetBookmark();
  bool has_bookmark() const { return has_bookmark_; }
  /// Restores all material, then the state at the bookmark, which waits for every session.
  void GoBack();

 private:
  struct Place {
    std::uint32_t solid, block;
  };
  struct Line {
    explicit Line(const CutUnion& all);
    void Wait(const Place& place);
    std::deque<Place> line;
    std::vector<std::vector<bool>> waits;  ///< for each solid, for each block
    std::uint64_t given = 0;
  };

  /// Calls use(place) for each block of the solids in which anything was cut.
  template <class Use>
  void ForEachCut(const Use& use) const;

  std::vector<CutField> cuts_;
  bool whole_ = true;
  std::map<std::uint32_t, Line> waiting_;  // by session
  bool has_bookmark_ = false;
  std::vector<CutBlock> bookmark_;
};

}  // namespace palpate
