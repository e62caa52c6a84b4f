#include "server/physics/rows/contact_place.h"

namespace palpate {

Vec3 LeverOf(const HapticModel& model, const ContactRows& rows, int row,
             const Mat3& R_WG) noexcept {
  const ContactId& id = rows.id(row);
  if (!id.IsOfLeaves()) return rows.lever(row);
  const LeafSphere& leaf = model.tool().leaves()[static_cast<std::size_t>(id.tool)];
  return R_WG * Vec3(leaf.x, leaf.y, leaf.z) - leaf.radius * rows.normal(row);
}

}  // namespace palpate
