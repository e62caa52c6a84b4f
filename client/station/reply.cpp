#include "client/station/reply.h"

#include <algorithm>
#include <iterator>

namespace palpate {

static_assert(std::size(decltype(wire::Wrench::row){}) == LocalRows::kMost);

Reply ToReply(const wire::Wrench& sample, std::int64_t received_ns) noexcept {
  Reply reply;
  reply.pose_sequence = sample.pose_sequence;
  reply.pose_time_ns = sample.pose_time_ns;
  reply.received_ns = received_ns;
  reply.X_WG = wire::ToPose(sample.graphic_position_m, sample.graphic_orientation_wxyz);
  reply.wrench = wire::ToWrench(sample);
  reply.step_time_s = sample.step_time_s;
  reply.contacts = sample.contacts;
  reply.faults = sample.faults;
  // A count beyond the array stays too large, so that LocalContactModel refuses it.
  reply.local.count = static_cast<int>(std::min<std::uint32_t>(sample.rows, LocalRows::kMost + 1));
  for (int i = 0; i < std::min(reply.local.count, LocalRows::kMost); ++i) {
    const double(&row)[6] = sample.row[i];
    reply.local.row[static_cast<std::size_t>(i)] = {
        {row[0], row[1], row[2]}, {row[3], row[4], row[5]}, sample.row_offset_m[i]};
  }
  reply.passive = {wire::ToVec3(sample.passive_force_N), wire::ToVec3(sample.passive_torque_Nm)};
  reply.active = {wire::ToVec3(sample.active_force_N), wire::ToVec3(sample.active_torque_Nm)};
  // The same sum as the server's, so that nothing remains without contact.
  const Wrench given = Sum(reply.passive, reply.active);
  reply.wrench.force -= given.force;
  reply.wrench.torque -= given.torque;
  reply.local.region_m = sample.region_m;
  reply.local.region_rad = sample.region_rad;
  reply.local.valid_s = sample.valid_s;
  return reply;
}

}  // namespace palpate
