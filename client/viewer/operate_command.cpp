#include "client/viewer/operate_command.h"

#include <algorithm>
#include <vector>

#include "common/dds/topics.h"
#include "common/json/json_file.h"

namespace palpate {
namespace {

/// In the order of idl/session.idl, and a goal.
const std::vector<std::string_view> kOps = {"admit", "take_back", "mute", "unmute", "goal"};

OperateCommand::Goal ReadGoal(const JsonNode& json) {
  json.AllowOnly({"op", "scene", "text", "limit_N"});
  const JsonNode text = json.At("text");
  OperateCommand::Goal goal{json.At("scene").Text(), text.Text(), json.At("limit_N").Number(0.0)};
  if (goal.text.size() > OperateCommand::Goal::kLongest) text.Fail("has more than 480 bytes");
  return goal;
}

}  // namespace

std::string_view OperateWishName(wire::OperateWish wish) {
  return kOps.at(static_cast<std::size_t>(wish));
}

OperateCommand ParseOperateCommand(std::string_view text) {
  const JsonNode json = JsonNode::Parse(text, "/palpate/operate");
  const std::string op = json.At("op").OneOf(kOps);
  OperateCommand command;
  if (op == "goal") {
    command.goal = ReadGoal(json);
    return command;
  }
  json.AllowOnly({"op", "station"});
  const JsonNode station = json.At("station");
  command.station = station.Text();
  if (!dds::IsStationName(command.station)) station.Fail("names no station");
  command.wish = static_cast<wire::OperateWish>(std::ranges::find(kOps, op) - kOps.begin());
  return command;
}

}  // namespace palpate
