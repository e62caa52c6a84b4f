#pragma once

#include "server/physics/contact_rows.h"
#include "server/physics/sphere_tree_query.h"

namespace palpate {

/// Contact constraint prediction (CCP, chapter 2.3.4): the rows that the next sub-step has to
/// respect. The chapter enlarges every sphere of the graphic tool by one delta, from the hand's
/// speed.  Here sphere i grows by delta_i = max_translation + max_rotation * |l_i|, and the
/// sub-step is held inside those two bounds: no pair that is left out can then collide in it,
/// whatever the hand does.
class ContactPrediction {
 public:
  ContactPrediction(const HapticModel& model);

  /// Fills `rows` for the graphic tool at R_WG with its reference point at p_W.
  /// Where `times` is given, adds to its prediction and rows stages.  Real-time.
  void Predict(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
               ContactRows& rows, StageTimes* times) noexcept;

 private:
  PairQuery query_;
};

}  // namespace palpate
