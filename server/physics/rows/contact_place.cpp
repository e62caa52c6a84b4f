#include "server/physics/rows/contact_place.h"

namespace palpate {

ContactPlace PlaceOf(const HapticModel& model, const ContactRows& rows, int row,
                     const Mat3& R_WG) noexcept {
  const LeafPair pair = rows.pair(row);
  if (KindOf(pair) != RowKind::kLeaves) {
    return {rows.lever(row), model.LeafOf(pair)};
  }
  const LeafSphere& leaf = model.tool().leaves()[static_cast<std::size_t>(pair.tool)];
  return {R_WG * Vec3(leaf.x, leaf.y, leaf.z) - leaf.radius * rows.normal(row), pair.object};
}

}  // namespace palpate
