#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "common/math/pose.h"
#include "server/physics/step_types.h"
#include "tests/benchmarks/truth.h"

namespace palpate::bench {

inline constexpr double kTruthStatic = 0.5, kTruthDynamic = 0.3;  ///< mu_s, mu_d

/// What must hold without friction, at each sample of a hand.
struct SmoothTruth {
  /// The only direction, or with `across` the plane across the only direction, in which bodies can
  /// push; unit, in W.  One for each sample, or one for all.
  std::vector<Vec3> axis;
  bool across = false;
  /// The force [N]; empty if it is unknown.  No torque comes with it.
  std::vector<Vec3> force = {};
};

/// Judges forces without friction.
class SmoothJudge {
 public:
  explicit SmoothJudge(SmoothTruth truth) : truth_(std::move(truth)) {}
  void See(std::size_t i, const StepReport& report);
  void Tell(Tally& tally) const;

 private:
  SmoothTruth truth_;
  double sideways_ = 0.0, off_ = 0.0, arrived_off_ = 0.0, torque_ = 0.0;
  int cycles_ = 0, late_ = 0, faults_ = 0;
};

/// A tool that is drawn along a plane.
struct SteadySlide {
  Vec3 normal, along;         ///< of the plane, of the hand's motion; unit, in W
  double speed;               ///< of the hand [m/s]
  double reach;               ///< of the tool from its centroid [m]
  double stiffness;           ///< k_t [N/m]
  std::size_t steady;         ///< from this sample on the tool must slide steadily
  std::vector<double> depth;  ///< of the hand, at each sample [m]
};

/// Judges steady sliding.  Where all points of a foot move alike, friction is mu_d of the load
/// against that motion, wherever the load rests.  They do once a hand that does not turn has slid
/// for a while: friction then tips the tool no further.  What is left is the tremor, which changes
/// the load, and so how far the tool is tipped:
/// - Turning about the normal moves points apart.  At w it adds at most w times the reach to the
///   hand's speed.  Cycles in which that is over a thousandth of the speed are counted but not
///   judged; of the others mu is right within 5e-7, and the direction within 0.06 degrees.
/// - Tilting at w moves all points of the foot alike, at most by w times the reach: so far the
///   direction may be off.
class SteadyJudge {
 public:
  SteadyJudge(SteadySlide slide, const Quat& start) : slide_(std::move(slide)), q_(start) {}
  void See(std::size_t i, const StepReport& report);
  void Tell(Tally& tally) const;

 private:
  /// @param turn  of the tool in this cycle [rad].
  void SeeSteady(std::size_t i, const Vec3& force, const Vec3& turn);

  SteadySlide slide_;
  Quat q_;
  Vec3 force_ = Vec3::Zero();
  double least_ = INFINITY, most_ = 0.0, direction_ = 0.0, change_ = 0.0;
  int touching_ = 0, judged_ = 0, turning_ = 0, late_ = 0, unsolved_ = 0, yielded_ = 0;
};

}  // namespace palpate::bench
