#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/dds/wire.h"

namespace palpate {

/// What a teacher's page sends on the channel /palpate/operate:
///   {"op": "admit" | "take_back" | "mute" | "unmute", "station": NAME}
struct OperateCommand {
  wire::OperateWish wish = palpate_OPERATE_ADMIT;
  std::string station;
};

/// Nothing, with the reason, for what is none: these two fields, and no others.
std::optional<OperateCommand> ParseOperateCommand(std::string_view json, std::string& complaint);

/// "admit", "take_back", "mute", "unmute".
const char* OperateWishName(wire::OperateWish wish);

}  // namespace palpate
