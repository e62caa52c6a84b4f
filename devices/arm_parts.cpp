#include "devices/arm_parts.h"

#include <Eigen/LU>

namespace palpate {

std::optional<Mat3> NearestRotation(const Mat3& matrix) noexcept {
  constexpr double kFarthest = 0.1;
  // Each iteration doubles the correct digits: 0.1, 1e-2, 1e-4, 1e-8, 1e-16.
  constexpr int kIterations = 5;
  if (!matrix.allFinite()) return std::nullopt;
  Mat3 R = matrix;
  for (int i = 0; i < kIterations; ++i) {
    if (!(R.determinant() > 0.5)) return std::nullopt;
    R = (0.5 * (R + R.inverse().transpose())).eval();
  }
  if (!((R - matrix).norm() <= kFarthest)) return std::nullopt;
  return R;
}

}  // namespace palpate
