#include "server/transport/scene_offer.h"

namespace palpate {
namespace {

template <class T, class Sequence>
void PointTo(std::vector<T>& items, Sequence& sequence) {
  sequence._buffer = items.data();
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(items.size());
  sequence._release = false;
}

}  // namespace

SceneOffer::SceneOffer(const std::vector<ServedScene>& scenes, std::uint64_t server_run) {
  for (const ServedScene& scene : scenes) Add(scene);
  sample_.server_run = server_run;
  PointTo(scenes_, sample_.scenes);
}

template <class Sequence>
void SceneOffer::AddHand(const std::vector<PoseScript::Key>& hand, Sequence& sequence) {
  std::vector<wire::HandKey>& keys = hands_.emplace_back();
  for (const PoseScript::Key& key : hand) {
    wire::HandKey& to = keys.emplace_back();
    to.time_s = key.t;
    wire::FromPose(key.X_WH, to.position_m, to.orientation_wxyz);
    wire::FromText(key.label, to.label);
  }
  PointTo(keys, sequence);
}

void SceneOffer::Add(const ServedScene& scene) {
  std::vector<wire::OfferedTool>& tools = tools_.emplace_back();
  for (const ServedScene::Tool& tool : scene.tools) {
    wire::OfferedTool& to = tools.emplace_back();
    wire::FromText(tool.served->tool, to.tool);
    wire::FromPose(tool.X_WT, to.start_position_m, to.start_orientation_wxyz);
    wire::FromText(tool.remark, to.remark);
    AddHand(tool.hand, to.hand);
  }
  wire::OfferedScene& to = scenes_.emplace_back();
  wire::FromText(scene.name, to.scene);
  wire::FromText(scene.file, to.file);
  AddHand(scene.hand, to.hand);
  PointTo(tools, to.tools);
}

}  // namespace palpate
