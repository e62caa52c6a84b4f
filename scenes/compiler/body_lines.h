#pragma once

#include <string>

#include "scenes/scene.h"

namespace palpate {

/// Returns one line for people: name, leaves and how they represent the mesh, triangles, place.
/// @param kind  "tool" or "object".
std::string BodyLine(const char* kind, const Body& body);
/// Returns a line for each group of objects that moves.
std::string MovedLines(const Scene& scene);

}  // namespace palpate
