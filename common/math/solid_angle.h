#pragma once

#include <cmath>

#include "common/math/elementary.h"
#include "common/math/pose.h"

namespace palpate {

/// Returns the signed solid angle of a triangle seen from the origin, at most 4 pi: positive from
/// behind, where its corners run clockwise (Van Oosterom & Strackee, IEEE T. Biomedical Engineering
/// 30 (1983) 125-126).
inline double SolidAngle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = a.norm();
  const double lb = b.norm();
  const double lc = c.norm();
  return 2.0 *
         Atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
}

}  // namespace palpate
