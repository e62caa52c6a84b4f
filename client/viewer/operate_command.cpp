#include "client/viewer/operate_command.h"

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

std::optional<OperateCommand> ParseOperateCommand(std::string_view text, std::string& complaint) {
  using Json = nlohmann::json;
  const auto refuse = [&](const char* why) {
    complaint = why;
    return std::nullopt;
  };
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return refuse("is no JSON object");
  const auto op = json.find("op");
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
  return refuse("its op is none of admit, take_back, mute and unmute");
}

}  // namespace palpate
