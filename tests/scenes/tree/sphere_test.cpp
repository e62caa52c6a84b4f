#include "scenes/tree/sphere.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::Numbers;

double Reach(const Vec3& from, const std::vector<Sphere>& balls) {
  double reach = 0.0;
  for (const Sphere& b : balls) reach = std::max(reach, (b.centre - from).norm() + b.radius);
  return reach;
}

std::vector<Sphere> RandomSpheres(Numbers& numbers, int count, double radius) {
  std::vector<Sphere> balls;
  for (int i = 0; i < count; ++i) balls.push_back({numbers.Point(1), numbers.Uniform(0, radius)});
  return balls;
}

TEST(EnclosingSphere, HoldsAllAndNoCentreNearbyNeedsLess) {
  Numbers numbers;
  for (int k = 0; k < 300; ++k) {
    const auto balls = RandomSpheres(numbers, 2 + k % 40, k % 3 * 0.5);
    const Sphere s = EnclosingSphere(balls);
    EXPECT_LE(Reach(s.centre, balls), s.radius * (1 + 1e-12));
    // The reach is a convex function of the centre, so a local minimum is global.
    for (int i = 0; i < 200; ++i) {
      const Vec3 other = s.centre + numbers.Point(i % 2 ? 1e-3 : 0.1);
      EXPECT_GE(Reach(other, balls), s.radius * (1 - 1e-9));
    }
  }
}

TEST(EnclosingSphere, OfAThousandCopiesIsTheOne) {
  const Sphere s = EnclosingSphere(std::vector<Sphere>(1000, {Vec3(1, 2, 3), 0.5}));
  EXPECT_EQ(s.centre, Vec3(1, 2, 3));
  EXPECT_EQ(s.radius, 0.5);
}

TEST(EnclosingSphere, TakesCentresOnALineAndInAPlane) {
  std::vector<Sphere> line, plane;
  for (int i = 0; i < 9; ++i) {
    line.push_back({Vec3(i, 0, 0), 0.1});
    plane.push_back({Vec3(i % 3, i / 3, 0), 0.1});
  }
  EXPECT_NEAR(EnclosingSphere(line).radius, 4.1, 1e-9);
  EXPECT_NEAR(EnclosingSphere(plane).radius, std::sqrt(2.0) + 0.1, 1e-9);
}

TEST(SphereQuery, FindsTheSameNearestAsLookingAtAll) {
  Numbers numbers;
  const auto balls = RandomSpheres(numbers, 300, 0.3);
  const SphereQuery query(balls);
  for (int k = 0; k < 300; ++k) {
    const Vec3 p = numbers.Point(1.5);
    std::vector<std::pair<double, std::uint32_t>> all;
    for (std::uint32_t i = 0; i < balls.size(); ++i) {
      all.push_back({(p - balls[i].centre).norm() - balls[i].radius, i});
    }
    std::sort(all.begin(), all.end());
    EXPECT_EQ(query.Nearest(p).ball, all[0].second);
    EXPECT_EQ(query.Nearest(p).distance, all[0].first);
    const auto few = query.NearestFew(p, 5);
    ASSERT_EQ(few.size(), 5u);
    for (int i = 0; i < 5; ++i) EXPECT_EQ(few[i], all[i].second);
    EXPECT_EQ(query.NearestFew(p, 5, all[5].first), few);
    EXPECT_EQ(query.NearestFew(p, 5, all[3].first).size(), 3u);
  }
  EXPECT_EQ(SphereQuery({balls[0], balls[1]}).NearestFew(Vec3::Zero(), 5).size(), 2u);
}

}  // namespace
}  // namespace palpate
