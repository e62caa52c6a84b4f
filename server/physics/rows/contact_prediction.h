#pragma once

#include <optional>

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/step_types.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

/// Contact constraint prediction (CCP, chapter 2.3.4): finds the rows that the next sub-step
/// must respect.  The chapter enlarges every sphere of the graphic tool by one delta, from the
/// hand's speed.  Here sphere i grows by delta_i = bounds.translation + bounds.rotation * |l_i|,
/// and the sub-step stays inside those bounds.  So no omitted pair can collide in it, however
/// far away the hand is.
class ContactPrediction {
 public:
  ContactPrediction(const HapticModel& model);

  /// Fills `rows` for the graphic tool at R_WG with its reference point at p_W.
  /// If `times` is given, adds to its prediction and rows stages.  Real-time.
  void Predict(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
               const StepBounds& bounds, ContactRows& rows, StageTimes* times) noexcept;

  /// Packet pairs tested since construction: a measure of cost.  An overflow of the rows adds more
  /// than a cycle may spend.
  std::int64_t tested() const { return query_ ? query_->tested() + counted_ : 0; }

  /// Returns whether any two leaves overlap.  Soft leaves count by their cores; those of objects
  /// that are felt by their meshes must overlap by kCoreDepth.  `rows` is scratch.  Real-time.
  bool Overlaps(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
                ContactRows& rows) noexcept;

 private:
  void Gather(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
              const StepBounds& bounds, ContactRows& rows, StageTimes* times) noexcept;

  std::optional<PairQuery> query_;  ///< empty if no leaf can touch
  /// After an overflow, a gap within which the tightest rows probably lie [m]; else 0.  A guess,
  /// which does not change the result.
  double near_ = 0.0;
  std::int64_t counted_ = 0;  ///< kMaxTested for each overflow, less the tests that guesses took
  std::optional<PairQuery> insides_;  ///< leaves of objects that are felt by their meshes
};

}  // namespace palpate
