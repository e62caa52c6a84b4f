#pragma once

#include <limits>

#include "common/math/pose.h"

namespace palpate {

/// Keeps a shortened vector inside its bound after rounding.
inline constexpr double kShortOfBound = 1.0 - 8.0 * std::numeric_limits<double>::epsilon();

/// Shortens a finite v to the bound, direction kept; true where that was needed.  Does not
/// overflow. Projection on a ball: two vectors are never further apart after it than before.
inline bool Shorten(Vec3& v, double bound) noexcept {
  const double largest = v.cwiseAbs().maxCoeff();
  if (largest == 0.0) return false;
  const Vec3 unit_ish = v / largest;  // norm in [1, sqrt 3]
  const double norm = unit_ish.norm();
  if (largest <= bound / norm) return false;
  v = unit_ish * (bound / norm * kShortOfBound);
  return true;
}

/// Moves v towards the target by at most `max_step`; true where that was not the whole way.
inline bool MoveTowards(Vec3& v, const Vec3& target, double max_step) noexcept {
  Vec3 step = target - v;
  const bool shortened = Shorten(step, max_step);
  v = shortened ? Vec3(v + step) : target;
  return shortened;
}

}  // namespace palpate
