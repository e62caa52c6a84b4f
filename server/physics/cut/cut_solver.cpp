#include "server/physics/cut/cut_solver.h"

#include <algorithm>
#include <cmath>

#include "server/physics/limits.h"

namespace palpate {
namespace {

using namespace limits::cutting;

/// Force of a row at the overlap s, and how it grows with s.
/// @param on  a row is on its spring, of the stiffness `rigid`, where a spring of this one has not
/// reached the threshold.  The energy's own is `rigid`.
inline double ForceAt(double s, double threshold, double viscous, double rigid, double on) {
  const double above = std::max(s, 0.0);
  return (on * above < threshold ? rigid * above : threshold) + viscous * above;
}
inline double StiffnessAt(double s, double threshold, double viscous, double rigid, double on) {
  if (!(s > 0.0)) return 0.0;
  return viscous + (on * s < threshold ? rigid : 0.0);
}

/// H d = -g in place; H is I and more: it has a Cholesky factor.
template <int N>
void SolveInPlace(double (&H)[N][N], double (&d)[N]) {
  for (int r = 0; r < N; ++r) {
    for (int c = 0; c <= r; ++c) {
      double sum = H[r][c];
      for (int k = 0; k < c; ++k) sum -= H[r][k] * H[c][k];
      H[r][c] = r == c ? std::sqrt(std::max(sum, 1e-300)) : sum / H[c][c];
    }
  }
  for (int r = 0; r < N; ++r) {
    for (int c = 0; c < r; ++c) d[r] -= H[r][c] * d[c];
    d[r] /= H[r][r];
  }
  for (int r = N - 1; r >= 0; --r) {
    for (int c = r + 1; c < N; ++c) d[r] -= H[c][r] * d[c];
    d[r] /= H[r][r];
  }
}

}  // namespace

CutSolver::CutSolver(int samples)
    : overlap_(static_cast<std::size_t>(samples)),
      change_(overlap_.size()),
      force_(overlap_.size()) {}

template <int N>
CutStep CutSolver::Solve(const double* t, const CutRows& rows, const double* guess) noexcept {
  const int count = rows.count();
  const double *P = rows.threshold(), *c = rows.viscous();
  double *s = overlap_.data(), *ds = change_.data(), *force = force_.data();
  CutStep result;
  double* x = result.x;
  std::copy(guess, guess + N, x);
  // Each row is a fold of the energy.  Newton's method sees none that it is not on, and goes to and
  // fro between hundreds.  Where it is not done in a few turns, the rows are made softer, so that
  // it is on many at once, and by stages stiffer from the result.  The first turn of a stage takes
  // those rows to be on their springs that were in the last one, for which it is exact; by the
  // stiffer energy they are so no longer at the x of the softer.
  double rigid = kRigid, on = kRigid;
  for (int of_stage = 0; result.turns < kTurns; ++result.turns, ++of_stage) {
    if (result.turns == kTurnsAtOnce) {
      rigid = on = kSoftest;
      of_stage = 0;
    }
    // `rounding`: what the gradient may be off by, for its terms, and for the overlaps on a ramp.
    double gradient[N], rounding[N], H[N][N] = {};
    for (int r = 0; r < N; ++r) {
      gradient[r] = x[r] - t[r];
      rounding[r] = std::abs(x[r]) + std::abs(t[r]);
      H[r][r] = 1.0;
    }
    for (int i = 0; i < count; ++i) {
      double sum = -rows.gap()[i], terms = rows.gap()[i];
      for (int r = 0; r < N; ++r) {
        const double term = rows.a(r)[i] * x[r];
        sum += term;
        terms += std::abs(term);
      }
      s[i] = sum;
      force[i] = ForceAt(sum, P[i], c[i], rigid, on);
      if (!(sum > 0.0)) continue;
      const double stiffness = StiffnessAt(sum, P[i], c[i], rigid, on);
      for (int r = 0; r < N; ++r) {
        const double push = force[i] * rows.a(r)[i];
        gradient[r] += push;
        rounding[r] += std::abs(push) + stiffness * terms * std::abs(rows.a(r)[i]);
        for (int q = 0; q <= r; ++q) H[r][q] += stiffness * rows.a(r)[i] * rows.a(q)[i];
      }
    }
    double d[N], slope = 0.0;
    result.solved = true;
    for (int r = 0; r < N; ++r) {
      d[r] = -gradient[r];
      result.solved = result.solved && std::abs(gradient[r]) <= kRounding * rounding[r];
    }
    if (on == rigid && (result.solved || (rigid < kRigid && of_stage >= kTurnsOfStage))) {
      if (rigid >= kRigid) break;
      rigid *= kStiffen;
      of_stage = -1;
      continue;
    }
    SolveInPlace(H, d);
    for (int r = 0; r < N; ++r) slope += gradient[r] * d[r];
    // Along the step the slope only rises: the least place is where it is 0, or the step's end.
    double moved = 0.0, towards = 0.0;
    for (int r = 0; r < N; ++r) {
      moved += d[r] * d[r];
      towards += (x[r] - t[r]) * d[r];
    }
    for (int i = 0; i < count; ++i) {
      double sum = 0.0;
      for (int r = 0; r < N; ++r) sum += rows.a(r)[i] * d[r];
      ds[i] = sum;
    }
    double low = 0.0, high = 1.0, part = 1.0;
    for (int search = 0; on == rigid && search < kSearches; ++search) {
      double here = towards + part * moved, bend = moved;
      for (int i = 0; i < count; ++i) {
        const double at = s[i] + part * ds[i];
        here += ForceAt(at, P[i], c[i], rigid, rigid) * ds[i];
        bend += StiffnessAt(at, P[i], c[i], rigid, rigid) * ds[i] * ds[i];
      }
      if (part == 1.0 && here <= 0.0) break;
      if (std::abs(here) <= -kSlopeLeft * slope) break;
      (here > 0.0 ? high : low) = part;
      part -= here / bend;
      if (!(part > low && part < high) || search % 2 == 1) part = 0.5 * (low + high);
    }
    for (int r = 0; r < N; ++r) x[r] += part * d[r];
    on = rigid;
  }
  for (int i = 0; i < count; ++i) {
    result.volume += rows.area()[i] * std::max(0.0, s[i]);
    result.work += force[i] * (s[i] + rows.gap()[i]);
  }
  return result;
}

template CutStep CutSolver::Solve<3>(const double*, const CutRows&, const double*) noexcept;
template CutStep CutSolver::Solve<6>(const double*, const CutRows&, const double*) noexcept;

}  // namespace palpate
