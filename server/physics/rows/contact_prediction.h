#pragma once

#include <optional>

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/step_types.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

/// Contact constraint prediction (CCP, chapter 2.3.4): the rows that the next sub-step has to
/// respect. The chapter enlarges every sphere of the graphic tool by one delta, from the hand's
/// speed.  Here sphere i grows by delta_i = bounds.translation + bounds.rotation * |l_i|, and the
/// sub-step is held inside those bounds: no pair that is left out can collide in it, however far
/// off the hand is.
class ContactPrediction {
 public:
  ContactPrediction(const HapticModel& model);

  /// Fills `rows` for the graphic tool at R_WG with its reference point at p_W.
  /// Where `times` is given, adds to its prediction and rows stages.  Real-time.
  void Predict(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
               const StepBounds& bounds, ContactRows& rows, StageTimes* times) noexcept;

  /// Packet pairs tested so far in the life of this prediction: what it costs, as a count.  Where
  /// there were more rows than there is room for, that is more than a cycle has.
  std::int64_t tested() const { return query_ ? query_->tested() + counted_ : 0; }

  /// True where any two leaves overlap, of soft ones their cores, of objects that are felt by their
  /// meshes by kCoreDepth.  `rows` is scratch.  Real-time.
  bool Overlaps(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
                ContactRows& rows) noexcept;

 private:
  void Gather(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
              const StepBounds& bounds, ContactRows& rows, StageTimes* times) noexcept;

  std::optional<PairQuery> query_;  ///< where any leaf can touch
  /// Where rows overflowed last: a gap that the tightest are likely within [m]; else 0.  A guess,
  /// which changes no bit.
  double near_ = 0.0;
  std::int64_t counted_ = 0;          ///< kMaxTested for each overflow, less what guesses took
  std::optional<PairQuery> insides_;  ///< where objects are felt by their meshes
};

}  // namespace palpate
