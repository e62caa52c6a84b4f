#pragma once

#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// Computes each object's `ambient`: for each vertex the share of the surrounding space that is
/// visible past all objects, 0 to 255, weighted by the cosine with the normal.  It makes a mouth
/// dark towards its throat.  Objects do not move, so this is done once, when the scene is
/// compiled, with depth images from many directions.  What can be scraped or cut off casts no
/// shade on the rest.
void LightObjects(std::vector<Body>& objects);

}  // namespace palpate
