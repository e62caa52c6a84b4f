#include "server/session/scene_changes.h"

#include <utility>

namespace palpate {

SceneChanges::SceneChanges(std::string scene, std::span<const CutSolid> solids,
                           std::uint64_t server_run)
    : scene_(std::move(scene)),
      cuts_(solids),
      solids_(solids, cuts_.cuts().cuts()),
      server_run_(server_run) {}

std::vector<SolidBlockNews> SceneChanges::TakeCuts(std::int64_t now_ns) {
  std::vector<SolidBlockNews> news;
  solids_.AddNews(now_ns, count_, news);
  for (SolidBlockNews& one : news) {
    wire::FromText(scene_, one.sample.scene);
    one.sample.server_run = server_run_;
  }
  return news;
}

std::vector<CutLogNews> SceneChanges::TakeCutLog(std::int64_t now_ns) {
  std::vector<CutLogNews> log = cuts_.TakeLog(now_ns);
  for (CutLogNews& one : log) {
    wire::FromText(scene_, one.sample.scene);
    one.sample.server_run = server_run_;
  }
  return log;
}

void SceneChanges::GoBack(std::int64_t now_ns) {
  const std::vector<CutField>& cuts = cuts_.cuts().cuts();
  const auto take_cut = [&] {
    for (std::uint32_t solid = 0; solid < cuts.size(); ++solid) {
      const SparseField& field = cuts[solid].field();
      for (std::uint32_t block = 0; block < field.lattice().block_count(); ++block) {
        if (field.entry(block) != SparseField::kBelow) solids_.Take(solid, block, now_ns);
      }
    }
  };
  take_cut();
  cuts_.GoBack();
  take_cut();
}

void SceneChanges::MakeWhole() {
  cuts_.MakeWhole();
  solids_.MakeWhole();
  undone_ = count_;
}

}  // namespace palpate
