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

/// What burs have cut of one scene since the server started or the scene was last made whole, in
/// the order that all sessions and viewers follow.  A later session starts with what is left.
///
/// Thread contract: service thread.
class SceneChanges {
 public:
  /// @param solids  that burs can cut; must outlive this
  SceneChanges(std::string scene, std::span<const CutSolid> solids, std::uint64_t server_run);
  SceneChanges(const SceneChanges&) = delete;  // solids_ refers to cuts_
  SceneChanges& operator=(const SceneChanges&) = delete;

  CutExchange& cuts() { return cuts_; }
  /// Notes that a block of a solid has changed.
  void TakeCut(std::uint32_t solid, std::uint32_t block, std::int64_t now_ns) {
    solids_.Take(solid, block, now_ns);
  }
  void TellAgain(const wire::SolidBlock& block, std::int64_t now_ns) {
    solids_.TellAgain(block, now_ns);
  }
  /// Return what is to be published now.
  std::vector<SolidBlockNews> TakeCuts(std::int64_t now_ns);
  std::vector<CutLogNews> TakeCutLog(std::int64_t now_ns);
  bool is_whole() const { return cuts_.cuts().is_whole(); }
  /// Restores the state at the bookmark of cuts().
  void GoBack(std::int64_t now_ns);
  /// Restores all material.  The numbers of changes continue.
  void MakeWhole();
  /// Number of the last change that was undone.
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
