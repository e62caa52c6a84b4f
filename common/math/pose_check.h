#pragma once

#include <cmath>

#include "common/math/pose.h"

namespace palpate {

/// Returns whether all numbers are finite and the squared length of the quaternion is 1 within
/// 1e-3, enough for numbers typed by people.
inline bool IsPose(const Pose& X) {
  return X.p.allFinite() && std::abs(X.q.squaredNorm() - 1.0) < 1e-3;
}

}  // namespace palpate
