#pragma once

#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// Gives each object's `ambient`: the share of the room that its vertices see past all objects, 0
/// to 255, weighted by the cosine with the normal.  It is what makes a mouth dark towards its
/// throat. Objects stand still, so it is found once, when the scene is compiled: by looking at them
/// from many directions, a picture of depths each.  What can be scraped or cut off shades nothing
/// else.
void LightObjects(std::vector<Body>& objects);

}  // namespace palpate
