#pragma once

#include <span>
#include <string>

#include "common/math/pose.h"
#include "server/physics/haptic_step.h"

namespace palpate::bench {

/// Returns a path's steps as CSV, with a header and one row per step:
///   step,hx,hy,hz,hqw,hqx,hqy,hqz,gx,gy,gz,gqw,gqx,gqy,gqz,fx,fy,fz,tx,ty,tz,contacts,faults,
///   substeps,step_us
/// h and g are X_WH and X_WG of the tool's frame [m, unit quaternion]; force [N] and torque [N m]
/// act on the hand at the tool's centroid, in W.  Numbers are written such that they read back to
/// the same bits, so that other oracles can judge the poses.
std::string StepTrace(std::span<const Pose> X_WH, std::span<const StepReport> steps,
                      std::span<const double> step_us);

}  // namespace palpate::bench
