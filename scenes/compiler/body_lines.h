#pragma once

#include <string>

#include "scenes/scene.h"

namespace palpate {

/// For people: name, leaves and how they stand for the mesh, triangles, place; a line.
/// @param kind  "tool" or "object".
std::string BodyLine(const char* kind, const Body& body);

/// The body of that name; the first object where it is empty.  Throws UsageError, with the nearest
/// name.
const Body& FindBody(const Scene& scene, const std::string& name);

}  // namespace palpate
