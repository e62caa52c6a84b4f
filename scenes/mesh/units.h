#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

namespace palpate {

/// What a number in a mesh file may mean.
inline constexpr std::array<std::string_view, 4> kUnits{"m", "cm", "mm", "inch"};
/// @param unit  one of them.
constexpr double MetresPerUnit(std::string_view unit) {
  return unit == "m" ? 1.0 : unit == "cm" ? 0.01 : unit == "mm" ? 0.001 : 0.0254;
}

/// For somebody who takes a mesh's numbers for one unit: another that gives it a size that a hand
/// feels, where that one hardly does; empty where none does; nothing where all is well.
/// @param longest  side of its box, in its numbers.
/// @param taken    what a number is taken for [m].
inline std::optional<std::string_view> LikelierUnit(double longest, double taken) {
  // A file of mm that is taken for m, or of m for mm, is beyond these from 4 mm, or up to 0.5 m,
  // on.
  constexpr double kMost_m = 4.0, kLeast_m = 5e-4;
  constexpr double kUsual_m = 0.05;  // a tooth, a tool, a statuette
  const auto is_felt = [](double metres) { return metres >= kLeast_m && metres <= kMost_m; };
  if (is_felt(longest * taken)) return std::nullopt;
  std::string_view likely;
  double least = std::numeric_limits<double>::infinity();
  for (const std::string_view unit : kUnits) {
    const double metres = longest * MetresPerUnit(unit);
    const double off = std::abs(std::log(metres / kUsual_m));
    if (off >= least || !is_felt(metres)) continue;
    least = off;
    likely = unit;
  }
  return likely;
}

/// Contact keeps meshes apart by StepTuning::separation, 1 um unless a scene says otherwise, and a
/// hand feels that as depth: under 1 % of a body whose longest side is no shorter than this [m].
inline constexpr double kShortestByMesh = 100e-6;
/// What is said of a shorter one, after its longest side.
inline constexpr std::string_view kTooShortByMesh =
    "contact keeps meshes 0.001 mm apart, which is felt as depth, and is more than 1 % of that "
    "side; give the scene a smaller \"separation_um\" (\"step\"), or enlarge it, and the hand's "
    "motion with it, until that side is at least 0.1 mm";

}  // namespace palpate
