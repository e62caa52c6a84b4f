#pragma once

#include <memory>

#include "scenes/scene.h"
#include "server/physics/haptic_model.h"

namespace palpate {

/// Makes the objects of a scene in the step's form.  The models of all tools of the scene
/// share them.
std::shared_ptr<const SceneObjects> MakeObjects(const Scene& scene);

/// Makes the model of one of the scene's tools, with the scene's features.  For other features,
/// change those of a copy of the scene first.  If tools touch each other, that of each but the last
/// has objects of its own: these, and the tools that the scene lists after it.
HapticModel MakeModel(const Scene& scene, const Body& tool,
                      std::shared_ptr<const SceneObjects> objects);

}  // namespace palpate
