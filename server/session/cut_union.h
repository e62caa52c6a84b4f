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

/// What all burs of a scene have taken of its solids, and which sessions have not been given all of
/// it yet.  A function of the calls alone: who makes them again in the same order is given the same
/// blocks with the same bits.
class CutUnion {
 public:
  /// The solids outlive this.  Throws Error where their fields do not fit into memory.
  explicit CutUnion(std::span<const CutSolid> solids);

  const std::vector<CutField>& cuts() const { return cuts_; }
  bool is_whole() const { return whole_; }
  /// A session that has all so far, and others' cuts from now on wait for it; or one that begins
  /// with nothing, and all waits.
  void Join(std::uint32_t session, bool has_all);
  void Leave(std::uint32_t session) { waiting_.erase(session); }
  /// A session's bur has changed a block.  True where that is news.
  bool Take(std::uint32_t session, const CutBlock& block);
  /// The next block that a session is to be given, as all have it now.
  bool Give(std::uint32_t session, CutBlock& block);
  bool has_all(std::uint32_t session) const { return waiting_.at(session).line.empty(); }
  /// All is there again, for all.
  void MakeWhole();
  /// Keeps how it stands, in place of what was kept before.
  void SetBookmark();
  bool has_bookmark() const { return has_bookmark_; }
  /// Whole again, and then as it stood at the bookmark: that waits for every session.
  void GoBack();

 private:
  struct Place {
    std::uint32_t solid, block;
  };
  struct Line {
    explicit Line(const CutUnion& all);
    void Wait(const Place& place);
    std::deque<Place> line;
    std::vector<std::vector<bool>> waits;  ///< of a solid's block
    std::uint64_t given = 0;
  };

  /// Calls use(place) for each block of the solids where anything was cut.
  template <class Use>
  void ForEachCut(const Use& use) const;

  std::vector<CutField> cuts_;
  bool whole_ = true;
  std::map<std::uint32_t, Line> waiting_;  // by session
  bool has_bookmark_ = false;
  std::vector<CutBlock> bookmark_;
};

}  // namespace palpate
