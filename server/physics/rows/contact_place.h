#pragma once

#include <cstdint>

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_rows.h"

namespace palpate {

/// What friction and reports need of a contact beyond its row.
/// @field lever        from the tool's reference point to the point where it touches, in W [m].
/// @field object_leaf  of the forest: whose material counts.
struct ContactPlace {
  Vec3 lever;
  std::int32_t object_leaf;
};

/// Where a row touches: the one place that knows what the id of a row means.
/// @param R_WG  orientation of the tool.  Not used for rows between meshes, which hold their lever.
/// Real-time.
ContactPlace PlaceOf(const HapticModel& model, const ContactRows& rows, int row,
                     const Mat3& R_WG) noexcept;

}  // namespace palpate
