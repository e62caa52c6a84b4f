#pragma once

#include <string>
#include <vector>

#include "scenes/tree_error.h"

namespace palpate {

/// MeasureLevels of a body, as programs print and write it.
struct BodyTreeError {
  std::string body;
  std::vector<UnionError> levels;  ///< coarsest first; the last are the leaves
};

/// A table for people, in micrometres and degrees.
std::string ToText(const BodyTreeError& error);
/// A line a level; lengths in metres, angles in degrees.
/// @param heading  begin with the line of names.
std::string ToCsv(const BodyTreeError& error, const std::string& mode, bool heading);
/// One object, as the CSV.
std::string ToJsonText(const BodyTreeError& error);

}  // namespace palpate
