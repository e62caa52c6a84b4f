#pragma once

#include <functional>
#include <string_view>

namespace palpate {

/// Is told the stage that long work is in, and the share of all the work that is done, 0 to 1.
using Progress = std::function<void(std::string_view stage, double fraction)>;

}  // namespace palpate
