#pragma once

#include <array>
#include <string_view>

namespace palpate {

/// What a number in a mesh file may mean.
inline constexpr std::array<std::string_view, 4> kUnits{"m", "cm", "mm", "inch"};
/// @param unit  one of them.
constexpr double MetresPerUnit(std::string_view unit) {
  return unit == "m" ? 1.0 : unit == "cm" ? 0.01 : unit == "mm" ? 0.001 : 0.0254;
}

}  // namespace palpate
