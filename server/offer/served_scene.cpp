#include "server/offer/served_scene.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

#include "common/error.h"
#include "scenes/catalogue.h"
#include "server/offer/generated_hand.h"
#include "server/physics/scene_model.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

void AddGeneratedHand(const Scene& scene, const Body& body, std::uint64_t seed,
                      ServedScene::Tool& tool) {
  const std::string about = "scene '" + scene.name + "' has no script of its own, ";
  if (const std::optional<PoseScript> hand = MakeHandFor(scene, body, tool.served->model, seed)) {
    tool.hand = hand->keys();
    tool.remark = about + "so the server made a hand for '" + body.name +
                  "' (palpate-server --hand-seed " + std::to_string(seed) +
                  "): it approaches the nearest face, presses 3 mm, slides, and lifts";
  } else {
    tool.remark = about + "and on the way from '" + body.name +
                  "' to the nearest face nothing pushes back, so no hand was made for it";
  }
}

}  // namespace

ServedScene ServeScene(const Scene& scene, const std::string& name_or_path,
                       std::uint64_t hand_seed) {
  ServedScene served;
  served.name = scene.name;
  served.file = fs::path(FindSceneFile(name_or_path)).filename().string();
  const std::string script = ScriptFileBeside(name_or_path);
  if (fs::exists(script)) served.hand = PoseScript::Load(script).keys();

  const auto objects = MakeObjects(scene);
  const bool whole_at_start = IsWholeAtStart(name_or_path);
  for (const Body& body : scene.tools) {
    ServedScene::Tool& tool = served.tools.emplace_back();
    tool.served = std::make_shared<const ServedTool>(ServedTool{
        scene.name, body.name, MakeModel(scene, body, objects), whole_at_start, scene.hands_meet});
    tool.X_WT = body.X_WB;
    if (const std::string own = ScriptFileBeside(name_or_path, body.name); own != script) {
      tool.hand = PoseScript::Load(own).keys();
    } else if (served.hand.empty()) {
      AddGeneratedHand(scene, body, hand_seed, tool);
    }
  }
  return served;
}

ServedScene SeatOf(const ServedScene& scene, const std::string& name) {
  ServedScene seat = scene;
  seat.name = name;
  for (ServedScene::Tool& tool : seat.tools) {
    tool.served = std::make_shared<const ServedTool>(tool.served->In(name));
  }
  return seat;
}

}  // namespace palpate
