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

/// Returns how many free bodies a scene has, and makes the model of one: what it may touch is what
/// stands still, and the bodies after it.  Members of a step (StepTogether) are a scene's tool, or
/// all of them if its hands meet, then these.
std::size_t CountFreeBodies(const Scene& scene);
HapticModel MakeBodyModel(const Scene& scene, std::size_t body);

}  // namespace palpate
