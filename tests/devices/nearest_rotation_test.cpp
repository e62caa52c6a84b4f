#include "devices/nearest_rotation.h"

#include <limits>
#include <random>

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "common/math/rotation.h"

namespace palpate {
namespace {

TEST(NearestRotation, IsThePolarFactorThatTheSingularValueDecompositionGives) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 phi = 3.0 * Vec3(uniform(random), uniform(random), uniform(random));
    Mat3 matrix = RotationExp(phi).toRotationMatrix();
    for (double& element : matrix.reshaped()) element += 0.01 * uniform(random);
    const Eigen::JacobiSVD<Mat3> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Mat3 truth = svd.matrixU() * svd.matrixV().transpose();
    const std::optional<Mat3> R = NearestRotation(matrix);
    ASSERT_TRUE(R);
    EXPECT_LT((*R - truth).norm(), 1e-14);
    EXPECT_LT((*R * R->transpose() - Mat3::Identity()).norm(), 1e-15 * 8);
  }
}

TEST(NearestRotation, RefusesWhatIsNoRotation) {
  Mat3 matrix = Mat3::Identity();
  matrix(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(NearestRotation(matrix));
  EXPECT_FALSE(NearestRotation(Mat3::Zero()));
  EXPECT_FALSE(NearestRotation(-Mat3::Identity()));
  EXPECT_FALSE(NearestRotation(Vec3(1, 1, -1).asDiagonal()));
  EXPECT_FALSE(NearestRotation(1.2 * Mat3::Identity()));
  EXPECT_FALSE(NearestRotation(1e200 * Mat3::Identity()));
}

}  // namespace
}  // namespace palpate
