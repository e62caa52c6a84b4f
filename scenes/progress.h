#pragma once

#include <functional>
#include <string_view>

namespace palpate {

/// Names a stage of long work and how much of all of it is done, 0 to 1.
using Progress = std::function<void(std::string_view stage, double fraction)>;

}  // namespace palpate
