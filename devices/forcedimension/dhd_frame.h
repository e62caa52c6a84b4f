#pragma once

#include "common/math/pose.h"

namespace palpate::dhd {

// The library's frame D has x towards the user, y to the right and z up; the device's frame W has
// x to the right, y up and z towards the user.  Both have their origin in the centre of the reach,
// so a rotation by 120 degrees about (1, 1, 1) converts D to W:
//
//        z_D = y_W
//         |
//         |
//         +------ y_D = x_W
//        /
//   x_D = z_W  (towards the user)

/// Converts a vector from D to W.
inline Vec3 ToW(const Vec3& v_D) noexcept {
  return {v_D.y(), v_D.z(), v_D.x()};
}
/// Converts a vector from W to D.
inline Vec3 ToD(const Vec3& v_W) noexcept {
  return {v_W.z(), v_W.x(), v_W.y()};
}
/// Converts a rotation from D to W.  The handle's frame is converted like the arm's, so that the
/// identity remains the identity.
inline Mat3 ToW(const Mat3& R_D) noexcept {
  Mat3 R_W;
  for (int column = 0; column < 3; ++column) {
    R_W.col(column) = ToW(Vec3(R_D.col((column + 1) % 3)));
  }
  return R_W;
}

}  // namespace palpate::dhd
