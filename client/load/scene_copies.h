#pragma once

#include <cstddef>
#include <string>

namespace palpate {

/// Writes a scene file like `scene` (a name or a file) with `copies` of its first tool, and the
/// scene's script beside it.  A server that serves it can be driven by that many stations, whose
/// tools do not touch each other.  Throws Error.
/// @param file  ends with .json.
void WriteSceneWithCopies(const std::string& scene, std::size_t copies, const std::string& file);

}  // namespace palpate
