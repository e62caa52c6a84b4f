#pragma once

#include <cstdint>
#include <optional>

#include "common/json/pose_script.h"
#include "scenes/scene.h"
#include "server/physics/haptic_model.h"

namespace palpate {

/// Makes a script of a hand for a scene that has none, so that the scene can be felt at once.
///
///    approach                  slide there and back                 lift
///       \                                                            /
///        \        .---->----.---->----.---->----.                   /
///    _____v______/___________________________<___\______________   /
///        press: 3 mm below the touching pose
///
/// The tool comes from where the scene places it or, if that is inside an object or at its surface,
/// from outside of it, straight to the face that is nearest to its surface.  It presses, slides
/// along the curved surface, returns the same way, lifts, and ends where it began.  The touching
/// poses are computed by the haptic step itself, run ahead of time, so soft objects, sphere trees
/// and meshes are touched as they will be.
///
/// The lengths given hold for objects of 10 mm to 1 m, and scale in proportion below and above.
/// @param seed  sets the direction of the slide.  The same scene, tool and seed give the same hand.
/// Returns nothing if the way to the nearest face meets nothing that pushes back.
/// Not real-time (some 10 ms): for when a scene loads.
std::optional<PoseScript> MakeHandFor(const Scene& scene, const Body& tool,
                                      const HapticModel& model, std::uint64_t seed);

}  // namespace palpate
