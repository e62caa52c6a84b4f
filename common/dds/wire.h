#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include <dds/dds.h>

#include "common/math/pose.h"
#include "idl/haptics.h"
#include "idl/offer.h"
#include "idl/operate.h"
#include "idl/progress.h"
#include "idl/replay.h"
#include "idl/session.h"
#include "idl/solid.h"
#include "idl/teaching.h"

/// The structs that are sent over DDS, as idlc generates them from idl/*.idl, under the
/// project's names.
namespace palpate::wire {

/// Topic descriptor of a wire type.
template <class T>
const dds_topic_descriptor_t& Descriptor();

// The types that have topics: those of the loop, and all others.  Use these lists to instantiate a
// template for each type.
// clang-format off
#define PALPATE_LOOP_TYPES(X) X(HapticPose) X(Wrench)
#define PALPATE_SERVICE_TYPES(X) \
  X(SessionRequest) X(SessionState) X(LoopWhole) X(OperateRequest) X(WholeRequest) X(SceneWhole) \
  X(ToolState) X(GuideTarget) X(LoopStatistics) X(StationStatistics) X(SceneBundle) \
  X(MovedState) X(SceneOffer) X(SceneProgress) X(SolidBlock) X(CutLog) X(ReplayContents) X(ReplayState) \
  X(ReplayRequest)
// clang-format on

#define PALPATE_WIRE_TYPE(T)                             \
  using T = palpate_##T;                                 \
  template <>                                            \
  inline const dds_topic_descriptor_t& Descriptor<T>() { \
    return palpate_##T##_desc;                           \
  }
PALPATE_LOOP_TYPES(PALPATE_WIRE_TYPE)
PALPATE_SERVICE_TYPES(PALPATE_WIRE_TYPE)
#undef PALPATE_WIRE_TYPE

// Types that are members of these.
using SessionPhase = palpate_SessionPhase;
using WholeWish = palpate_WholeWish;
using CutEvent = palpate_CutEvent;
using CutStep = palpate_CutStep;
using OperateWish = palpate_OperateWish;
using HandKey = palpate_HandKey;
using OfferedTool = palpate_OfferedTool;
using OfferedScene = palpate_OfferedScene;
using ReplayMark = palpate_ReplayMark;
using ReplayGap = palpate_ReplayGap;
using ReplayWish = palpate_ReplayWish;
using BodyPose = palpate_BodyPose;

// Loop types have no padding, so that the C struct is the CDR payload byte for byte (a test
// compares them) and shared memory carries it as it is.
static_assert(sizeof(HapticPose) == 2 * 8 + 13 * 8 + 2 * 4);
static_assert(offsetof(HapticPose, position_m) == 16 && offsetof(HapticPose, buttons) == 120);
static_assert(sizeof(Wrench) == 2 * 8 + 13 * 8 + 36 * 8 + 12 * 8 + 12 * 8 + 4 * 8 + 8 + 6 * 4);
static_assert(offsetof(Wrench, row) == 120 && offsetof(Wrench, step) == 632);

// Conversions between wire arrays and common/math.  Real-time: plain copies.

inline Vec3 ToVec3(const double (&a)[3]) noexcept {
  return {a[0], a[1], a[2]};
}
inline void FromVec3(const Vec3& v, double (&a)[3]) noexcept {
  a[0] = v.x();
  a[1] = v.y();
  a[2] = v.z();
}
/// The quaternion is copied, not normalised: the servo loop checks it.
inline Pose ToPose(const double (&p)[3], const double (&wxyz)[4]) noexcept {
  return {ToVec3(p), Quat(wxyz[0], wxyz[1], wxyz[2], wxyz[3])};
}
inline void FromPose(const Pose& X, double (&p)[3], double (&wxyz)[4]) noexcept {
  FromVec3(X.p, p);
  wxyz[0] = X.q.w();
  wxyz[1] = X.q.x();
  wxyz[2] = X.q.y();
  wxyz[3] = X.q.z();
}
inline Pose ToPose(const HapticPose& s) noexcept {
  return ToPose(s.position_m, s.orientation_wxyz);
}
inline palpate::Wrench ToWrench(const Wrench& s) noexcept {
  return {ToVec3(s.force_N), ToVec3(s.torque_Nm)};
}

/// Copies text into a bounded string, cut to its size.
template <std::size_t N>
void FromText(std::string_view text, char (&field)[N]) noexcept {
  const std::size_t n = text.copy(field, N - 1);
  for (std::size_t i = n; i < N; ++i) field[i] = '\0';
}

}  // namespace palpate::wire
