#include "tests/support/hand_path.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/test_scenes.h"

namespace palpate::test {
namespace {

Scene BoxOnBall(double size) {
  return MakeScene(MakeBox(size * Vec3(0.4, 0.2, 0.3)), 64, MakeSphere(0.5 * size, 320), 64,
                   ContactModel::kSpheres);
}

TEST(HandPath, BeginsFreeAndComesInAndLeavesAgain) {
  const Scene scene = BoxOnBall(0.1);
  const MeshOracle oracle(scene);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const std::vector<Pose> hand = MakeHand(scene, {seed, 0.2, 6000});
    EXPECT_FALSE(oracle.Meet(hand.front()));
    int inside = 0, comes = 0;
    bool in = false;
    double deepest = 0.0;
    for (std::size_t i = 0; i < hand.size(); i += 10) {
      const MeshOracle::Overlap overlap = oracle.At(hand[i]);
      inside += overlap.meet;
      comes += overlap.meet && !in;
      in = overlap.meet;
      deepest = std::max(deepest, overlap.depth);
    }
    EXPECT_GT(comes, 3) << "seed " << seed;
    EXPECT_GT(inside, 100) << "seed " << seed;
    EXPECT_LT(inside, 590) << "seed " << seed;
    EXPECT_GT(deepest, 0.0015) << "seed " << seed;
    EXPECT_LT(deepest, 0.02) << "seed " << seed;
  }
}

TEST(HandPath, PressesAsDeepAsAsked) {
  const Scene scene = BoxOnBall(0.1);
  const MeshOracle oracle(scene);
  const auto deepest = [&](double press_mm) {
    double depth = 0.0;
    for (const Pose& X_WH : MakeHand(scene, {.seed = 1, .steps = 2000, .press_mm = press_mm})) {
      depth = std::max(depth, oracle.At(X_WH).depth);
    }
    return depth;
  };
  EXPECT_LT(deepest(1.0), 0.004) << "a squeeze adds up to 3 mm";
  EXPECT_GT(deepest(10.0), 0.005);
}

TEST(HandPath, IsAsFastAsAskedAndNoFasterThanAHandSpeedsUp) {
  const Scene scene = BoxOnBall(0.1);
  const double half_radius = 0.25 * 0.1 * Vec3(0.4, 0.2, 0.3).norm();
  for (const double speed : {0.02, 0.1, 0.5}) {
    const std::vector<Pose> hand = MakeHand(scene, {3, speed, 4000});
    double way = 0.0, fastest_change = 0.0;
    Vec3 before = Vec3::Zero();
    for (std::size_t i = 1; i < hand.size(); ++i) {
      const Vec3 v = hand[i].p - hand[i - 1].p;
      const double turn = half_radius * RotationLog(hand[i].q * hand[i - 1].q.conjugate()).norm();
      way += std::hypot(v.norm(), turn);
      if (i > 1) fastest_change = std::max(fastest_change, (v - before).norm());
      before = v;
    }
    EXPECT_NEAR(way / 4.0, speed, 0.2 * speed);
    // 30 m/s^2, or more where a sample spans the seam of two moves.
    EXPECT_LT(fastest_change / 1e-6, speed < 0.2 ? 40.0 : 400.0) << speed;
  }
}

TEST(HandPath, IsInProportionForTheVerySmallAndTheVeryLarge) {
  for (const double size : {2e-3, 20.0}) {
    const Scene scene = BoxOnBall(size);
    const MeshOracle oracle(scene);
    // 0.01 m/s for the small one and 5 m/s for the large one, so that both come to touch.
    const std::vector<Pose> hand = MakeHand(scene, {5, size < 1.0 ? 0.01 : 5.0, 3000});
    // 2 to 4 mm for sizes of 10 mm to 1 m; the tool is 0.4 of the size long.
    const double scale = size < 1.0 ? 0.4 * size / 0.01 : 0.4 * size;
    double deepest = 0.0;
    for (std::size_t i = 0; i < hand.size(); i += 10) {
      deepest = std::max(deepest, oracle.At(hand[i]).depth);
    }
    EXPECT_GT(deepest, 1e-3 * scale) << size;
    EXPECT_LT(deepest, 15e-3 * scale) << size;
  }
}

TEST(HandPath, SaysWhenThereIsNothingToTouch) {
  Scene scene = BoxOnBall(0.1);
  scene.objects[0].mesh.triangles.clear();
  EXPECT_THROW(MakeHand(scene, {}), Error);
}

}  // namespace
}  // namespace palpate::test
