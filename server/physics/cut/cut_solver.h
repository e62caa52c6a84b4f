#pragma once

#include <vector>

#include "server/physics/cut/cut_rows.h"

namespace palpate {

/// @field x        the step [m], of which the first N count
/// @field turns    of Newton's method
/// @field solved   false: the turns were used up, and x is where they ended
/// @field volume   sum of A_i delta_i: what the rows say is cut [m^3]
/// @field work     that the step does on the material, over k_t [m^2]: >= 0
struct CutStep {
  double x[6] = {};
  int turns = 0;
  bool solved = false;
  double volume = 0.0;
  double work = 0.0;
};

/// Minimises 1/2 |x - t|^2 + sum P_i delta_i + c_i delta_i^2 / 2 with delta_i = max(0, a_i . x -
/// g_i), in the N unknowns, 3 or 6: the step of a tool that cuts (cut_rows.h), over k_t.  The force
/// that holds the tool back is k_t (t - x), as everywhere.
///
/// Below the threshold a row is rigid: its force lies anywhere in [0, P_i] while delta_i = 0.  Here
/// it is a spring, limits::cutting::kRigid times as stiff as the coupling, until it has the force
/// P_i.  That energy is convex and piecewise quadratic, and is minimised by Newton's method over
/// its pieces, with a search along the step where its slope turns (Qi & Sun, Math. Programming 58
/// (1993) 353-367; as simd/compliant.inl, whose rows have no threshold).
///
/// Passive: forces are >= 0 only where a_i . x >= g_i >= 0, so that the work is >= 0, whatever x
/// is.
class CutSolver {
 public:
  /// @param samples  of the largest bur.  Set-up.
  explicit CutSolver(int samples);

  /// @param t      N values [m], finite.   @param guess  N values, the last step's x or zero.
  /// Real-time: no allocation, lock or clock.  Deterministic.
  template <int N>
  CutStep Solve(const double* t, const CutRows& rows, const double* guess) noexcept;

  /// Force of each row at the result, over k_t [m]: k_t times it is newtons.
  const double* forces() const { return force_.data(); }

 private:
  std::vector<double> overlap_, change_, force_;
};

}  // namespace palpate
