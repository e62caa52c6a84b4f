#pragma once

#include <memory>

#include "scenes/scene.h"
#include "server/physics/haptic_model.h"

namespace palpate {

/// All objects of a scene, as the step wants them; shared by the models of the scene's tools.
std::shared_ptr<const SceneObjects> MakeObjects(const Scene& scene);

/// The model of one of the scene's tools, with the scene's features.  For other features, change
/// those of a copy of the scene first.
HapticModel MakeModel(const Scene& scene, const Body& tool,
                      std::shared_ptr<const SceneObjects> objects);

}  // namespace palpate
