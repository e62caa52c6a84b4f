#include "server/session/scene_changes.h"

#include <algorithm>
#include <utility>

#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

SceneChanges::SceneChanges(std::string scene, std::shared_ptr<const SceneRemains> whole,
                           std::span<const CutSolid> solids, std::uint64_t server_run)
    : scene_(std::move(scene)), whole_(std::move(whole)), server_run_(server_run) {
  if (whole_) remains_ = *whole_;
  if (solids.empty()) return;
  cuts_.emplace(solids);
  solids_.emplace(solids, cuts_->cuts().cuts());
}

std::vector<wire::SceneChange> SceneChanges::Remove(const Session& session,
                                                    const Removal& removal) {
  const ObjectForest& objects = session.tool().model.objects();
  const int object = objects.ObjectOf(removal.leaf);
  const auto leaf = static_cast<std::uint32_t>(removal.leaf - objects.FirstLeafOf(object));
  std::vector<wire::SceneChange> changes;
  if (remains_->leaf_gone(static_cast<std::uint32_t>(object), leaf)) return changes;
  gone_.push_back(removal.leaf);
  const std::vector<std::uint32_t> triangles =
      remains_->Remove(static_cast<std::uint32_t>(object), leaf);
  std::size_t told = 0;
  do {
    wire::SceneChange change{};
    constexpr std::size_t kRoom = std::size(decltype(change.triangle){});
    wire::FromText(scene_, change.scene);
    change.change = ++count_;
    change.server_run = server_run_;
    wire::FromText(session.station(), change.station);
    wire::FromText(session.tool().tool, change.tool);
    change.pose_sequence = removal.pose_sequence;
    change.object_index = static_cast<std::uint32_t>(object);
    change.leaf = leaf;
    const std::size_t n = std::min(triangles.size() - told, kRoom);
    std::copy_n(triangles.begin() + static_cast<std::ptrdiff_t>(told), n, change.triangle);
    change.triangles = static_cast<std::uint32_t>(n);
    told += n;
    changes.push_back(change);
  } while (told < triangles.size());
  return changes;
}

std::vector<SolidBlockNews> SceneChanges::TakeCuts(std::int64_t now_ns) {
  std::vector<SolidBlockNews> news;
  if (solids_) solids_->AddNews(now_ns, count_, news);
  for (SolidBlockNews& one : news) {
    wire::FromText(scene_, one.sample.scene);
    one.sample.server_run = server_run_;
  }
  return news;
}

std::vector<CutLogNews> SceneChanges::TakeCutLog(std::int64_t now_ns) {
  if (!cuts_) return {};
  std::vector<CutLogNews> log = cuts_->TakeLog(now_ns);
  for (CutLogNews& one : log) {
    wire::FromText(scene_, one.sample.scene);
    one.sample.server_run = server_run_;
  }
  return log;
}

void SceneChanges::GoBack(std::int64_t now_ns) {
  const std::vector<CutField>& cuts = cuts_->cuts().cuts();
  const auto take_cut = [&] {
    for (std::uint32_t solid = 0; solid < cuts.size(); ++solid) {
      const SparseField& field = cuts[solid].field();
      for (std::uint32_t block = 0; block < field.lattice().block_count(); ++block) {
        if (field.entry(block) != SparseField::kBelow) solids_->Take(solid, block, now_ns);
      }
    }
  };
  take_cut();
  cuts_->GoBack();
  take_cut();
}

void SceneChanges::MakeWhole() {
  if (whole_) remains_ = *whole_;
  if (cuts_) cuts_->MakeWhole();
  if (solids_) solids_->MakeWhole();
  gone_.clear();
  undone_ = count_;
}

}  // namespace palpate
