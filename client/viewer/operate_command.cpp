#include "client/viewer/operate_command.h"

#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/dds/topics.h"

namespace palpate {

const char* OperateWishName(wire::OperateWish wish) {
  switch (wish) {
    case palpate_OPERATE_ADMIT:
      return "admit";
    case palpate_OPERATE_TAKE_BACK:
      return "take_back";
    case palpate_OPERATE_MUTE:
      return "mute";
    case palpate_OPERATE_UNMUTE:
      return "unmute";
  }
  return "?";
}

namespace {

std::optional<OperateCommand> ParseGoal(const nlohmann::json& json, std::string& complaint) {
  const auto scene = json.find("scene");
  const auto text = json.find("text");
  const auto limit = json.find("limit_N");
  OperateCommand::Goal goal;
  if (json.size() != 4 || scene == json.end() || text == json.end() || limit == json.end() ||
      !scene->is_string() || !text->is_string() || !limit->is_number()) {
    complaint = "of a goal has other fields than op, scene, text and limit_N";
    return std::nullopt;
  }
  goal.scene = scene->get<std::string>();
  goal.text = text->get<std::string>();
  goal.limit = limit->get<double>();
  if (goal.text.size() > OperateCommand::Goal::kLongest || !(goal.limit >= 0.0) ||
      !std::isfinite(goal.limit)) {
    complaint = "of a goal has a text of more than 480 bytes, or a limit that is no force";
    return std::nullopt;
  }
  OperateCommand command;
  command.goal = std::move(goal);
  return command;
}

}  // namespace

std::optional<OperateCommand> ParseOperateCommand(std::string_view text, std::string& complaint) {
  using Json = nlohmann::json;
  const auto refuse = [&](const char* why) {
    complaint = why;
    return std::nullopt;
  };
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return refuse("is no JSON object");
  const auto op = json.find("op");
  if (op != json.end() && *op == "goal") return ParseGoal(json, complaint);
  const auto station = json.find("station");
  if (json.size() != 2 || op == json.end() || station == json.end() || !op->is_string() ||
      !station->is_string()) {
    return refuse("has other fields than op and station, two texts");
  }
  OperateCommand command;
  command.station = station->get<std::string>();
  if (!dds::IsStationName(command.station)) return refuse("names no station");
  for (const wire::OperateWish wish : {palpate_OPERATE_ADMIT, palpate_OPERATE_TAKE_BACK,
                                       palpate_OPERATE_MUTE, palpate_OPERATE_UNMUTE}) {
    if (op->get_ref<const std::string&>() == OperateWishName(wish)) {
      command.wish = wish;
      return command;
    }
  }
  return refuse("its op is none of admit, take_back, mute, unmute and goal");
}

}  // namespace palpate
