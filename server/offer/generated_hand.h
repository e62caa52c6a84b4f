#pragma once

#include <cstdint>
#include <optional>

#include "common/json/pose_script.h"
#include "scenes/scene.h"
#include "server/physics/haptic_model.h"

namespace palpate {

/// A hand for a scene that comes without a script of its own, so that it can be felt at once.
///
///    approach                  slide there and back                 lift
///       \                                                            /
///        \        .---->----.---->----.---->----.                   /
///    _____v______/___________________________<___\______________   /
///         press: 3 mm below the touching pose
///
/// The tool comes from where the scene places it, or, where that is inside an object or at its
/// surface, from outside of it: straight to the face that is nearest to its surface.  It presses,
/// slides along as the surface bends, goes back as it came, lifts, and ends where it began.  Where
/// each touching pose is, the haptic step itself says, walked ahead of time: so soft objects,
/// sphere trees and meshes are touched as they will be.
///
/// Lengths are as said for objects of 10 mm to 1 m, and in proportion below and above.
/// @param seed  which way it slides.  The same scene, tool and seed give the same hand.
/// Nothing where the way to the nearest face meets nothing that pushes back.
/// Not real-time (some 10 ms): for when a scene loads.
std::optional<PoseScript> MakeHandFor(const Scene& scene, const Body& tool,
                                      const HapticModel& model, std::uint64_t seed);

}  // namespace palpate
