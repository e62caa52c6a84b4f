#pragma once

#include <span>
#include <string>

#include "common/math/pose.h"
#include "server/physics/haptic_step.h"

namespace palpate::bench {

/// A path's steps as CSV, the header first, a row a step:
///   step,hx,hy,hz,hqw,hqx,hqy,hqz,gx,gy,gz,gqw,gqx,gqy,gqz,fx,fy,fz,tx,ty,tz,contacts,faults,
///   substeps,step_us
/// h and g are X_WH and X_WG of the tool's frame [m, unit quaternion]; force [N] and torque [N m]
/// act on the hand at the tool's centroid, in W.  Numbers read back to the same bits, so that
/// anyone's oracle can judge the poses.
std::string StepTrace(std::span<const Pose> X_WH, std::span<const StepReport> steps,
                      std::span<const double> step_us);

}  // namespace palpate::bench
