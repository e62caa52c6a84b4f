#include "client/station/pose_lead.h"

#include <algorithm>

#include "common/math/rotation.h"

namespace palpate {
namespace {

/// Returns v, shortened to at most `most`.
Vec3 Within(const Vec3& v, double most) noexcept {
  const double size = v.norm();
  return size > most ? Vec3(v * (most / size)) : v;
}

}  // namespace

void PoseLead::Hear(double round_trip_s) noexcept {
  if (!(round_trip_s >= 0.0)) return;
  round_trip_s_ += (std::min(round_trip_s, kMost_s) - round_trip_s_) / kReplies;
}

double PoseLead::lead_s() const noexcept {
  const double share = std::clamp((round_trip_s_ - kNear_s) / (kFar_s - kNear_s), 0.0, 1.0);
  return share * (round_trip_s_ + kHeld_s);
}

Pose PoseLead::Lead(std::int64_t now_ns, const Pose& X_WH) noexcept {
  Seen& oldest = seen_[count_++ % kWindow];
  const Seen then = oldest;
  oldest = {now_ns, X_WH};
  const double lead = lead_s();
  const double since_s = 1e-9 * static_cast<double>(now_ns - then.time_ns);
  if (count_ <= kWindow || lead == 0.0 || !(since_s > 0.0)) return X_WH;
  const double times = lead / since_s;
  const Vec3 v = Within(times * (X_WH.p - then.X_WH.p), kMost_m);
  const Vec3 phi = Within(times * RotationLog(X_WH.q * then.X_WH.q.conjugate()), kMost_rad);
  // Sends a pose that is not finite as it is; the server refuses it.  Later poses are not affected.
  if (!v.allFinite() || !phi.allFinite()) return X_WH;
  return {X_WH.p + v, (RotationExp(phi) * X_WH.q).normalized()};
}

}  // namespace palpate
