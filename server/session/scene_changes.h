#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/dds/wire.h"
#include "server/session/cut_exchange.h"
#include "server/session/session.h"
#include "server/session/solid_changes.h"

namespace palpate {

/// What burs have cut of one scene since the server began, or since it was made whole: the order
/// that all sessions and viewers follow.  A session that begins later begins with what is left.
///
/// Thread contract: service thread.
class SceneChanges {
 public:
  /// @param solids  that burs cut; outlive this.
  SceneChanges(std::string scene, std::span<const CutSolid> solids, std::uint64_t server_run);
  SceneChanges(const SceneChanges&) = delete;  // what is shown looks into what is cut
  SceneChanges& operator=(const SceneChanges&) = delete;

  CutExchange& cuts() { return cuts_; }
  /// A block of a solid is another than it was.
  void TakeCut(std::uint32_t solid, std::uint32_t block, std::int64_t now_ns) {
    solids_.Take(solid, block, now_ns);
  }
  void TellAgain(const wire::SolidBlock& block, std::int64_t now_ns) {
    solids_.TellAgain(block, now_ns);
  }
  /// What is to be published of it now.
  std::vector<SolidBlockNews> TakeCuts(std::int64_t now_ns);
  std::vector<CutLogNews> TakeCutLog(std::int64_t now_ns);
  bool is_whole() const { return cuts_.cuts().is_whole(); }
  /// As it stood at the bookmark of cuts().
  void GoBack(std::int64_t now_ns);
  /// All is there again.  Changes are numbered on.
  void MakeWhole();
  /// Number of the last change that is undone.
  std::uint64_t undone() const { return undone_; }

 private:
  std::string scene_;
  CutExchange cuts_;
  SolidChanges solids_;
  std::uint64_t server_run_;
  std::uint64_t count_ = 0;
  std::uint64_t undone_ = 0;
};

}  // namespace palpate
