#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "common/dds/wire.h"

namespace palpate {

/// What a teacher's page sends on the channel /palpate/operate:
///   {"op": "admit" | "take_back" | "mute" | "unmute", "station": NAME}
///   {"op": "goal", "scene": NAME, "text": TEXT, "limit_N": NUMBER}
struct OperateCommand {
  /// What students are told of a scene.
  struct Goal {
    static constexpr std::size_t kLongest = 480;  ///< bytes: 120 letters of any script
    std::string scene;
    std::string text;    ///< empty, with no limit: there is no goal any more
    double limit = 0.0;  ///< of the force [N]; 0: none
  };
  wire::OperateWish wish = palpate_OPERATE_ADMIT;
  std::string station;
  std::optional<Goal> goal;  ///< then the rest does not count
};

/// Throws Error for what is none: these fields, and no others.
OperateCommand ParseOperateCommand(std::string_view json);

/// "admit", "take_back", "mute", "unmute".
std::string_view OperateWishName(wire::OperateWish wish);

}  // namespace palpate
