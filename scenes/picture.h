#pragma once

#include <optional>
#include <string>

#include "scenes/scene.h"

namespace palpate {

/// Draws each distinct body of the scene as a row of pictures, as a PNG: the mesh, then the spheres
/// of every level of its tree (chapter 2, Fig. 2.10), or of one level only.  Rows are in the order
/// of the scene file, tools first; palpate-scene info tells how many spheres each level has. Throws
/// UsageError if no body has the level, Error if the file cannot be written.
void DrawScene(const Scene& scene, std::optional<int> level, const std::string& png_file);

/// Draws the scene as a whole: the objects, each in its own colour, and the tools, in orange, at
/// their start poses.  Throws Error if the file cannot be written.
void DrawWhole(const Scene& scene, const std::string& png_file);

}  // namespace palpate
