#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/dds/wire.h"
#include "scenes/scene_remains.h"
#include "server/session/cut_exchange.h"
#include "server/session/session.h"
#include "server/session/solid_changes.h"

namespace palpate {

/// What tools have scraped or cut off one scene since the server began, or since it was made whole:
/// the order that all sessions and viewers follow.  A leaf goes once, whoever was first; a session
/// that begins later begins with what is left.
///
/// Thread contract: service thread.
class SceneChanges {
 public:
  /// @param whole   the scene as it is loaded; null: nothing wears there.
  /// @param solids  that burs cut; outlive this.
  SceneChanges(std::string scene, std::shared_ptr<const SceneRemains> whole,
               std::span<const CutSolid> solids, std::uint64_t server_run);
  SceneChanges(const SceneChanges&) = delete;  // what is shown looks into what is cut
  SceneChanges& operator=(const SceneChanges&) = delete;

  /// Records that a leaf has gone.  Returns what to publish: one change, or several where its
  /// triangles are many; none where the leaf had gone before.
  std::vector<wire::SceneChange> Remove(const Session& session, const Removal& removal);
  /// What burs cut; null where nothing can be.
  CutExchange* cuts() { return cuts_ ? &*cuts_ : nullptr; }
  /// A block of a solid is another than it was.
  void TakeCut(std::uint32_t solid, std::uint32_t block, std::int64_t now_ns) {
    solids_->Take(solid, block, now_ns);
  }
  void TellAgain(const wire::SolidBlock& block, std::int64_t now_ns) {
    solids_->TellAgain(block, now_ns);
  }
  /// What is to be published of it now.
  std::vector<SolidBlockNews> TakeCuts(std::int64_t now_ns);
  std::vector<CutLogNews> TakeCutLog(std::int64_t now_ns);
  bool is_whole() const { return gone_.empty() && (!cuts_ || cuts_->cuts().is_whole()); }
  bool wears() const { return whole_ != nullptr; }
  /// As it stood at the bookmark of cuts().
  void GoBack(std::int64_t now_ns);
  /// All is there again.  Changes are numbered on.
  void MakeWhole();
  /// Number of the last change that is undone.
  std::uint64_t undone() const { return undone_; }
  /// Leaves that have gone, first to last, as the forest numbers them.
  const std::vector<std::int32_t>& gone() const { return gone_; }

 private:
  std::string scene_;
  std::shared_ptr<const SceneRemains> whole_;
  std::optional<SceneRemains> remains_;
  std::optional<CutExchange> cuts_;
  std::optional<SolidChanges> solids_;
  std::uint64_t server_run_;
  std::uint64_t count_ = 0;
  std::uint64_t undone_ = 0;
  std::vector<std::int32_t> gone_;
};

}  // namespace palpate
