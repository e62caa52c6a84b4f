#pragma once

/// @file
/// All of palpate::physics: from two meshes to a wrench.
///
/// @code
/// Scene scene;
/// scene.objects.push_back(MakeBody("block", MakeBox({0.04, 0.04, 0.04})));
/// scene.tools.push_back(MakeBall("ball", 0.005));
/// const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
/// Proxy proxy(model, X_WH);                       // not real-time, as all above
/// const StepReport report = proxy.Step(X_WH);     // real-time, once a millisecond
/// @endcode
///
/// Lengths are metres, forces newtons, angles radians; X_AB is the pose of frame B in frame A: W
/// the world, H the haptic tool (the hand), G the graphic tool, which never enters an object.
/// Setting up may throw palpate::Error; a step never throws, but reports StepReport::faults.
///
/// What is declared here, and its documentation, is kept from one minor version to the next.
/// Other headers may change, and so may the bits of a result (CHANGELOG.md).
#include "common/error.h"                     // IWYU pragma: export
#include "common/math/pose.h"                 // IWYU pragma: export
#include "common/math/rotation.h"             // IWYU pragma: export
#include "common/step_fault.h"                // IWYU pragma: export
#include "scenes/scene.h"                     // IWYU pragma: export
#include "scenes/shapes/shapes.h"             // IWYU pragma: export
#include "scenes/tree/sphere_tree_builder.h"  // IWYU pragma: export
#include "server/library/body_builder.h"      // IWYU pragma: export
#include "server/library/parameters.h"        // IWYU pragma: export
#include "server/library/proxy.h"             // IWYU pragma: export
#include "server/library/state_bytes.h"       // IWYU pragma: export
#include "server/library/version.h"           // IWYU pragma: export
#include "server/physics/haptic_model.h"      // IWYU pragma: export
#include "server/physics/haptic_step.h"       // IWYU pragma: export
#include "server/physics/scene_model.h"       // IWYU pragma: export
#include "server/physics/start_pose.h"        // IWYU pragma: export

// The library was built with 16; a program that is built for AVX would lay out poses differently.
static_assert(alignof(palpate::Pose) == 16,
              "Eigen aligns to more than palpate was built with: compile with "
              "-DEIGEN_MAX_STATIC_ALIGN_BYTES=16, as palpate::physics and palpate-physics.pc do");
