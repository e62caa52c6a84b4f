#pragma once

#include <optional>
#include <string>

#include "scenes/scene.h"

namespace palpate {

/// Draws each of the scene's distinct bodies as a row of pictures: the mesh, then the spheres of
/// every level of its tree (chapter 2, Fig. 2.10), or of one level only.  Writes a PNG.
/// Throws UsageError where no body has the level, Error where the file cannot be written.
void DrawScene(const Scene& scene, std::optional<int> level, const std::string& png_file);

/// Draws the scene as it stands: the objects, each of its own colour, and the tools, orange, where
/// they start.  Throws Error where the file cannot be written.
void DrawWhole(const Scene& scene, const std::string& png_file);

}  // namespace palpate
