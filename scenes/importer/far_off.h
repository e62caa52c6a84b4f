#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "common/math/pose.h"

namespace palpate {

/// A mesh file's text, moved.
struct MovedText {
  std::string text;
  Vec3 by;  ///< what was taken off each vertex, a whole number
};

/// Moves a mesh to its origin before an importer reads it in single precision, which far from there
/// loses what a file says in double: of OBJ, text STL, and PLY as text or with coordinates of type
/// double.  The first vertex goes to less than one unit from the origin.
/// @param format  as MeshFormatOf gives it.
/// Nothing where the format's numbers are of single precision themselves, or the text is not as
/// usual.
std::optional<MovedText> MoveToOrigin(const std::string& format, std::string_view text);

}  // namespace palpate
