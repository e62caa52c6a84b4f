#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// Holds what a mesh file declares of its own size against what is there, before an importer
/// believes it: elements of a PLY, facets of an STL, chunks of a .glb and a 3DS.  A file that is
/// cut short is refused with what was declared and found, not read as far as it goes.
/// @param format  "ply", as MeshFormatOf gives it; of a format that declares nothing, nothing is
///                checked.
/// Throws Error without the file's name.
void CheckDeclaredSize(const std::string& format, std::string_view text);

}  // namespace palpate
