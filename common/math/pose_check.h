#pragma once

#include <cmath>

#include "common/math/pose.h"

namespace palpate {

/// Whether all numbers are finite and the quaternion's length is 1, to the digits that people
/// write.
inline bool IsPose(const Pose& X) {
  return X.p.allFinite() && std::abs(X.q.squaredNorm() - 1.0) < 1e-3;
}

}  // namespace palpate
