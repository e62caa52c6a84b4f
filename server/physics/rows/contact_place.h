#pragma once

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_rows.h"

namespace palpate {

/// From the tool's reference point to the point where a row touches, in W [m].
/// @param R_WG  orientation of the tool.  Not used for rows between meshes, which hold their lever.
/// Real-time.
Vec3 LeverOf(const HapticModel& model, const ContactRows& rows, int row, const Mat3& R_WG) noexcept;

}  // namespace palpate
