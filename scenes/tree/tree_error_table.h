#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "scenes/tree/tree_error.h"

namespace palpate {

/// The result of MeasureLevels for a body, for output.
struct BodyTreeError {
  std::string body;
  std::vector<UnionError> levels;  ///< coarsest first; the last are the leaves
};

/// Explains the levels of a tree to readers of the figures.
inline constexpr std::string_view kWhatLevelsAre =
    "levels 1 to N-1 bound the leaves below them (for the contact prediction); the leaves are what "
    "is felt";

/// Explains the columns of a table, one per line, and then kWhatLevelsAre.
std::string AboutLevelTable();

/// The unit of a table's lengths.
struct LengthUnit {
  const char* name;
  double per_metre;
  int digits;  ///< after the decimal point
};
/// Returns the unit in which all lengths fit into seven places: um, mm or m.
LengthUnit UnitOf(const std::vector<BodyTreeError>& errors);

/// Returns a table for people, 109 columns wide: lengths, degrees, percent.
std::string LevelTable(const std::vector<UnionError>& levels, const LengthUnit& unit);
/// Returns that table under the body's name.
std::string ToText(const BodyTreeError& error);
/// Returns {"body": ..., "levels": [...]}: each figure's name ends with its unit, as
/// "signed_offset_um": {"p99": ...}.
std::string ToJsonText(const BodyTreeError& error);

}  // namespace palpate
