#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenes/tree/tree_error.h"

namespace palpate {

/// MeasureLevels of a body, as programs print and write it.
struct BodyTreeError {
  std::string body;
  std::vector<UnionError> levels;  ///< coarsest first; the last are the leaves
};

/// What the levels of a tree are, for people who read the figures.
inline constexpr std::string_view kWhatLevelsAre =
    "levels 1 to N-1 bound the leaves below them (for the contact prediction); the leaves are what "
    "is felt";

/// What the columns of a table are, a line each, and kWhatLevelsAre.
std::string AboutLevelTable();

/// What a table's lengths are in.
struct LengthUnit {
  const char* name;
  double per_metre;
  int digits;  ///< behind the point
};
/// In which no length of the tables takes more than seven places: um, mm or m.
LengthUnit UnitOf(const std::vector<BodyTreeError>& errors);

/// A table for people, 109 columns wide: lengths, degrees, percent.
std::string LevelTable(const std::vector<UnionError>& levels, const LengthUnit& unit);
/// The same under the body's name.
std::string ToText(const BodyTreeError& error);
/// A line a level; every figure's name ends in its unit and what it is of the spread, as
/// "signed_offset_um_p99".
/// @param mode  of the tree.   @param heading  begin with the line of names.
std::string ToCsv(const BodyTreeError& error, std::string_view mode, bool heading);
/// {"body": ..., "levels": [...]}, the same figures: "signed_offset_um": {"p99": ...}.
std::string ToJsonText(const BodyTreeError& error);

}  // namespace palpate
