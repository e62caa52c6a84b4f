#pragma once

#include <memory>

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/step_state.h"
#include "server/physics/step_types.h"

namespace palpate {

struct StepBuffers;  // solve/step_context.h

/// Whether the tool cuts in a step to X_WH: what each step asks first.  An edge does so as long as
/// the hand draws it in its sense, which of the state changes `drawn`.
bool CutsInStep(const HapticModel& model, const Pose& X_WH, StepState& state) noexcept;

/// Buffers that a step needs, allocated once.  One per thread that steps, of any number of tools of
/// one model; holds no state from step to step.
class StepWorkspace {
 public:
  explicit StepWorkspace(const HapticModel& model);
  ~StepWorkspace();
  StepWorkspace(StepWorkspace&&) noexcept;
  StepBuffers& buffers() { return *buffers_; }

 private:
  std::unique_ptr<StepBuffers> buffers_;
};

/// The haptic step, once per millisecond and tool: finds the pose of the graphic tool nearest to
/// the haptic tool's without entering an object, and the wrench of the spring between the two.
/// Chapter 2.3 and 2.4; README.md has the cycle, server/DECISIONS.md where it departs from them.
/// `X_WH`: haptic tool, of the tool tree's frame.  Non-finite poses set kFaultBadPose.
/// `times`: null in the servo loop; where given, the stages are timed (the result is the same).
/// Real-time: no allocation, lock, log; a clock only where `times` is given.
/// Deterministic: equal inputs, equal bits, whatever the build type, SIMD level or thread.
StepReport HapticStep(const HapticModel& model, const Pose& X_WH, StepState& state,
                      StepWorkspace& workspace, StageTimes* times = nullptr) noexcept;

}  // namespace palpate
