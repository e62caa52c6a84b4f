#include "client/viewer/server_desk.h"

#include <functional>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "client/viewer/class_room.h"
#include "common/dds/random_run.h"
#include "common/realtime/steady_clock.h"

namespace palpate {

FramePtr ServerDesk::AskReplay(ReplayWish wish, Viewer& viewer, std::int64_t now_ns) {
  std::string refusal = viewers_.Refuse(Wish::kReplay, viewer, now_ns);
  if (refusal.empty()) {
    wish.request.request = RandomRun();
    wire::FromText(viewer.guest().Who(), wish.request.by);
    refusal = feed_.Ask(wish.request);
  }
  // One instance per kind of wish: an answer replaces only an answer to the same kind.
  return OwnFrame(TopicFeed::kReplayAnswer, wish.request.kind,
                  ReplayAnswer(wish.tag, wish.request.request, refusal));
}

std::string ServerDesk::Operate(const OperateCommand& command, const std::string& by) {
  if (command.goal) {
    const auto& [scene, text, limit] = *command.goal;
    // The number of scenes is bounded, so goals cannot fill the memory.
    if (!feed_.scenes().contains(scene)) return "scene '" + scene + "' is not served here";
    std::vector<std::string> all = SeatsOf(scene, NamesOf(feed_.scenes()));
    all.push_back(scene);
    for (const std::string& one : all) {
      const nlohmann::json json = {{"scene", one}, {"text", text}, {"limit_N", limit}};
      const FramePtr frame =
          OwnFrame(TopicFeed::kGoal, std::hash<std::string>{}(one), ToText(json));
      goals_[one] = frame;
      const std::int64_t now_ns = SteadyNanoseconds();
      for (const auto& [id, viewer] : viewers_.all()) viewer->Push(frame, now_ns);
    }
    spdlog::info("{}: the goal of '{}' is set", by, scene);
    return "";
  }
  if (feed_.server().run == 0) return "no server has been found";
  wire::OperateRequest request{};
  wire::FromText(command.station, request.station);
  request.server_run = feed_.server().run;
  request.request = RandomRun();
  request.wish = command.wish;
  wire::FromText(by, request.by);
  if (!feed_.Ask(request)) return "the network is busy; try again";
  spdlog::info("{}: {} station '{}'", by, OperateWishName(command.wish), command.station);
  return "";
}

}  // namespace palpate
