#pragma once

#include <array>
#include <cstdint>

#include "common/dds/wire.h"
#include "common/math/pose.h"
#include "common/realtime/ring.h"

namespace palpate {

/// A row of a reply's local contact model: row . [v; phi] >= offset for a step of the graphic tool
/// from Reply::X_WG.  v is the displacement of the tool's reference point, phi the rotation, both
/// in W.
struct LocalRow {
  Vec3 normal = Vec3::Zero();              ///< unit, from object to tool
  Vec3 lever_cross_normal = Vec3::Zero();  ///< [m]
  double offset = 0.0;                     ///< [m]; at most 0, unless a jam leaves the row violated
};

/// A reply's local contact model, as defined in idl/haptics.idl.
struct LocalRows {
  static constexpr int kMost = 6;
  int count = 0;  ///< as received, unchecked: may have any value
  std::array<LocalRow, kMost> row;
  double region_m = 0.0;
  double region_rad = 0.0;
  double valid_s = 0.0;
};

/// A server's answer to a pose, without DDS: the part of wire::Wrench that the loop needs.
struct Reply {
  std::uint64_t pose_sequence = 0;  ///< the pose that it answers
  std::int64_t pose_time_ns = 0;    ///< when that pose was sampled, by this station's clock
  std::int64_t received_ns = 0;     ///< by the same clock
  Pose X_WG;                        ///< the graphic tool
  Wrench wrench;             ///< of contacts, on the hand, at the tool's reference point, in W
  double step_time_s = 0.0;  ///< the server's, from take to write
  std::uint32_t contacts = 0;
  std::uint32_t faults = 0;
  LocalRows local = {};
  /// Wrenches of effects at that pose; frame and point as `wrench`.
  Wrench passive = {}, active = {};
};

/// Carries replies from DDS's receiving thread to the servo thread; holds a quarter of a second of
/// them.  A ring and not a mailbox: when two replies arrive within a tick, the older one counts as
/// late, not as lost.  If the ring is full, the servo thread has not read for that long and its
/// device renders nothing anyway.
using ReplyRing = Ring<Reply, 256>;

inline Wrench Sum(const Wrench& a, const Wrench& b) noexcept {
  return {a.force + b.force, a.torque + b.torque};
}

/// Converts a sample without checking it.  Real-time.
Reply ToReply(const wire::Wrench& sample, std::int64_t received_ns) noexcept;

}  // namespace palpate
