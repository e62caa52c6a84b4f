#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "common/math/elementary.h"

namespace palpate {

/// The units that a mesh file may be in.
inline constexpr std::array<std::string_view, 4> kUnits{"m", "cm", "mm", "inch"};
/// @param unit  one of kUnits.
constexpr double MetresPerUnit(std::string_view unit) {
  return unit == "m" ? 1.0 : unit == "cm" ? 0.01 : unit == "mm" ? 0.001 : 0.0254;
}

/// Suggests another unit for a mesh, if it hardly has a size that can be felt in the one assumed:
/// the unit in which its size is most usual, or empty if none fits.  Returns nothing if its size
/// can be felt.
/// @param longest  the longest side of its box, in its numbers.
/// @param taken    the unit assumed [m].
inline std::optional<std::string_view> LikelierUnit(double longest, double taken) {
  // A file in mm read as m exceeds these limits if the body is longer than 4 mm; one in m read as
  // mm, if it is shorter than 0.5 m.
  constexpr double kMost_m = 4.0, kLeast_m = 5e-4;
  constexpr double kUsual_m = 0.05;  // a tooth, a tool, a statuette
  const auto is_felt = [](double metres) { return metres >= kLeast_m && metres <= kMost_m; };
  if (is_felt(longest * taken)) return std::nullopt;
  std::string_view likely;
  double least = std::numeric_limits<double>::infinity();
  for (const std::string_view unit : kUnits) {
    const double metres = longest * MetresPerUnit(unit);
    const double off = std::abs(Log(metres / kUsual_m));
    if (off >= least || !is_felt(metres)) continue;
    least = off;
    likely = unit;
  }
  return likely;
}

/// The shortest longest side of a body whose mesh is felt well [m].  Contact keeps meshes apart by
/// StepTuning::separation, 1 um unless a scene says otherwise, which a hand feels as depth: under 1
/// % of a body of this size.
inline constexpr double kShortestByMesh = 100e-6;
/// The remark about a shorter body, after its longest side.
inline constexpr std::string_view kTooShortByMesh =
    "contact keeps meshes 0.001 mm apart, which is felt as depth, and is more than 1 % of that "
    "side; give the scene a smaller \"separation_um\" (\"step\"), or enlarge it, and the hand's "
    "motion with it, until that side is at least 0.1 mm";

}  // namespace palpate
