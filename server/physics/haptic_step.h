#pragma once

#include <memory>
#include <span>

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/step_state.h"
#include "server/physics/step_types.h"

namespace palpate {

struct StepBuffers;  // solve/step_context.h
struct Together;     // solve/step_context.h

/// Returns whether the tool cuts in the step to X_WH; each step calls this first.  An edge starts
/// and stops cutting only after the hand has drawn it some distance (limits::cutting::kDraw), which
/// `state.cut.drawn` counts, so the tremor of a resting hand does not toggle it.
bool CutsInStep(const HapticModel& model, const Pose& X_WH, StepState& state) noexcept;

/// The buffers that a step needs, allocated once.  Each thread that steps needs its own, which
/// serves any number of tools of one model.  It holds no state from step to step.
class StepWorkspace {
 public:
  explicit StepWorkspace(const HapticModel& model);
  ~StepWorkspace();
  StepWorkspace(StepWorkspace&&) noexcept;
  StepBuffers& buffers() { return *buffers_; }

 private:
  std::unique_ptr<StepBuffers> buffers_;
};

/// The haptic step, once per millisecond and tool.  Finds the pose of the graphic tool that is
/// nearest to the haptic tool's without entering an object, and the wrench of the spring between
/// the two.  Chapter 2.3 and 2.4; README.md explains the cycle, server/DECISIONS.md lists where it
/// departs from the chapter.
/// `X_WH`: pose of the haptic tool (frame of the tool's tree).  A non-finite pose sets
/// kFaultBadPose.
/// `times`: null in the servo loop; otherwise receives the times of the stages (same result).
/// Real-time: no allocation, lock or log; reads a clock only if `times` is given.
/// Deterministic: equal inputs give equal bits, whatever the build type, SIMD level or thread.
StepReport HapticStep(const HapticModel& model, const Pose& X_WH, StepState& state,
                      StepWorkspace& workspace, StageTimes* times = nullptr) noexcept;

/// One member of a step of several: a hand's tool, or a free body, whose model has an Inertia.
struct ToolStep {
  const HapticModel* model = nullptr;
  Pose X_WH{};  ///< as of HapticStep; a body's is set by the step
  StepState* state = nullptr;
  StepWorkspace* workspace = nullptr;
  /// Of its spring, what acts: above 0, to 1; the report's forces are of the whole spring.  0: the
  /// tool is not there, and its state and report stay as they are.
  double share = 1.0;
  double period = 1e-3;  ///< of a body, since the last step [s]
  StepReport report{};   ///< out
};

/// The buffers that a step of several tools needs beside their own.  Set-up.
class TogetherWorkspace {
 public:
  /// Throws Error if StepTogether cannot step tools of these models together.
  explicit TogetherWorkspace(std::span<const HapticModel* const> models);
  ~TogetherWorkspace();
  Together& buffers() { return *buffers_; }

 private:
  std::unique_ptr<Together> buffers_;
};

/// HapticStep for tools that can touch each other, and bodies that are free, two to kMostMembers in
/// all: one problem, whose solution is the poses nearest to all hands', each by its spring's
/// energy, and to the bodies' free motion, each by its inertia, in which nothing enters anything.
/// So what two members feel of each other is equal and opposite (solve/together.md,
/// solve/free_bodies.md).
///
/// Hands come first.  For each pair of members, one model, and only one, has the other member as an
/// object (PlacedTree: `tool` is its index here, and `frame` is a frame of its own).  All must be
/// rigid meshes (balls may be the first of a pair only), without chapter friction, soft leaves,
/// burs, and effects.
/// Call Leave of a tool's frames when it is no longer there, and before it comes back.
/// A tool whose pose is not usable stays at its last hand's, and feels nothing (kFaultBadPose).
/// Real-time and deterministic, as HapticStep.
void StepTogether(std::span<ToolStep> tools, TogetherWorkspace& workspace) noexcept;

}  // namespace palpate
