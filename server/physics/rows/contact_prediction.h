#pragma once

#include <optional>
#include <span>

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/step_types.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

/// Where a sub-step may end: within `bounds` of the motion [v; phi].
struct StepEnds {
  StepBounds bounds;
  Vec3 v = Vec3::Zero(), phi = Vec3::Zero();
};

/// Contact constraint prediction (CCP, chapter 2.3.4): finds the rows that the next sub-step
/// must respect.  The chapter enlarges every sphere of the graphic tool by one delta, from the
/// hand's speed.  Here sphere i grows by delta_i = bounds.translation + bounds.rotation * |l_i|,
/// and the sub-step stays inside those bounds.  So no omitted pair can collide in it, however
/// far away the hand is.
class ContactPrediction {
 public:
  ContactPrediction(const HapticModel& model);

  /// Fills `rows` for the graphic tool at R_WG with its reference point at p_W: with all pairs that
  /// a sub-step could bring together that ends as `ends` says, and goes there straight.
  ///
  /// Where it ends near another place than it begins, the spheres grow there, by the bounds and by
  /// L^2 / 2r.  A point that goes straight by L, from outside of a ball of radius r to where its
  /// distance d from the centre has d^2 >= r^2 + L^2, is outside on the whole way:
  ///
  ///      begin *-----L-----* end       Where the way first goes inwards, the angle at its end is
  ///             \        /            acute; so the nearest point of the way, a foot or the
  ///            r \     / d            beginning, is no nearer than r.
  ///                o
  ///
  /// If `times` is given, adds to its prediction and rows stages.  Real-time.
  /// @param may_crowd  if false, the search also ends where rows become a crowd: more than kCrowd,
  ///                   and more than kCrowdATest for each packet pair that was tested
  /// Returns false if it ended, or not all rows fit: `rows` lacks some.
  bool Predict(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
               const StepEnds& ends, ContactRows& rows, StageTimes* times,
               bool may_crowd = true) noexcept;

  /// Fills `rows` with those of given pairs of leaves.
  void Take(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
            std::span<const ContactId> ids, ContactRows& rows) noexcept;

  /// Packet pairs tested since construction: a measure of cost.
  std::int64_t tested() const { return query_ ? query_->tested() : 0; }

  /// Returns whether any two leaves overlap.  Soft leaves count by their cores; those of objects
  /// that are touched by their meshes must overlap by kCoreDepth.  Real-time.
  bool Overlaps(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                const Vec3& p_W) noexcept;

 private:
  std::optional<PairQuery> query_;    ///< empty if no leaf can touch
  double least_radii_ = 0.0;          ///< least sum of the radii of a pair [m]
  std::optional<PairQuery> insides_;  ///< leaves of objects that are touched by their meshes
};

}  // namespace palpate
