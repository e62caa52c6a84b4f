#include "scenes/moved_group.h"

#include <cmath>
#include <cstdint>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::HasSubstr;

/// Opens by 20 degrees about an axis that does not go through the origin, and closes again.
MovedGroup Jaw() {
  MovedGroup jaw{.name = "jaw", .point = {0.0, 0.01, -0.09}, .axis = Vec3::UnitX(), .keys = {}};
  jaw.keys = {{0, 0.0, Vec3::Zero()}, {1000, M_PI / 9.0, Vec3::Zero()}, {3000, 0.0, Vec3::Zero()}};
  return jaw;
}

TEST(MovedGroup, TurnsAboutItsAxis) {
  const MovedGroup jaw = Jaw();
  EXPECT_TRUE(jaw.At(0).p.isZero(0.0));
  const Pose open = jaw.At(1000);
  EXPECT_TRUE((open * jaw.point).isApprox(jaw.point, 1e-14));
  const Vec3 tooth(0.01, 0.0, -0.01), arm = tooth - jaw.point;
  const Vec3 turned(arm.x(), std::cos(M_PI / 9.0) * arm.y() - std::sin(M_PI / 9.0) * arm.z(),
                    std::sin(M_PI / 9.0) * arm.y() + std::cos(M_PI / 9.0) * arm.z());
  EXPECT_LT((open * tooth - jaw.point - turned).norm(), 1e-15);
  EXPECT_LT((jaw.At(9999) * tooth - tooth).norm(), 1e-15);  // after the last key
}

TEST(MovedGroup, RestsAtItsKeysIfItIsSmoothAndElseGoesAtEqualSpeed) {
  MovedGroup lift{.name = "lift", .keys = {}};
  lift.keys = {{0, 0.0, Vec3::Zero()}, {1000, 0.0, Vec3(0.0, 0.0, 0.1)}};
  EXPECT_NEAR(lift.At(1).p.z(), 0.1 * 3e-6, 1e-9);
  EXPECT_NEAR(lift.At(500).p.z(), 0.05, 1e-15);
  EXPECT_NEAR(lift.At(501).p.z() - lift.At(500).p.z(), 1.5e-4, 1e-9);
  lift.smooth = false;
  for (const int i : {0, 1, 250, 999, 1000}) EXPECT_NEAR(lift.At(i).p.z(), 1e-4 * i, 1e-15);
}

TEST(MovedGroup, RepeatsWithoutAJump) {
  MovedGroup table{.name = "table", .point = {0.02, 0.0, 0.0}, .axis = Vec3::UnitY(), .keys = {}};
  table.keys = {{0, 0.0, Vec3::Zero()}, {4000, 2.0 * M_PI, Vec3::Zero()}};
  table.smooth = false;
  table.repeats = true;
  EXPECT_EQ(MotionFault(table), "");
  const Vec3 on(0.1, 0.0, 0.0);
  for (const int i : {0, 1, 3999, 4000, 4001, 400'000'000}) {
    EXPECT_NEAR((table.At(i + 1) * on - table.At(i) * on).norm(),
                2.0 * 0.08 * std::sin(M_PI / 4000.0), 1e-12)
        << i;
  }
}

TEST(MovedGroup, RefusesWhatIsNoMotion) {
  const auto fault = [](auto change) {
    MovedGroup jaw = Jaw();
    change(jaw);
    return MotionFault(jaw);
  };
  EXPECT_EQ(fault([](MovedGroup&) {}), "");
  EXPECT_THAT(fault([](MovedGroup& g) { g.keys.resize(1); }), HasSubstr("has no motion"));
  EXPECT_THAT(fault([](MovedGroup& g) { g.axis *= 2.0; }), HasSubstr("about no axis"));
  EXPECT_THAT(fault([](MovedGroup& g) { g.point.x() = NAN; }), HasSubstr("about no axis"));
  EXPECT_THAT(fault([](MovedGroup& g) { g.keys[0].turn = 0.1; }), HasSubstr("does not begin"));
  EXPECT_THAT(fault([](MovedGroup& g) { g.keys[2].at = 1000; }), HasSubstr("not in the order"));
  EXPECT_THAT(fault([](MovedGroup& g) { g.keys[2].at = INT64_MIN; }),
              HasSubstr("not in the order"));
  EXPECT_THAT(fault([](MovedGroup& g) { g.keys[1].turn = NAN; }), HasSubstr("goes faster"));
  EXPECT_THAT(fault([](MovedGroup& g) { g.keys[1].at = 10; }), HasSubstr("goes faster"));
  EXPECT_THAT(fault([](MovedGroup& g) { g.keys[1].shift.x() = 1.0; }), HasSubstr("goes faster"));
  EXPECT_THAT(fault([](MovedGroup& g) {
                g.repeats = true;
                g.keys[2].turn = 0.1;
              }),
              HasSubstr("not where it begins"));
}

TEST(FreeBody, IsRefusedIfNoSolidIsLikeIt) {
  FreeBody body{0.02, Vec3::Zero(), Vec3(1e-6, 2e-6, 2e-6).asDiagonal()};
  const auto fault_with = [&](auto change) {
    FreeBody changed = body;
    change(changed);
    return MotionFault(MovedGroup{.name = "body", .free = changed});
  };
  EXPECT_EQ(fault_with([](FreeBody&) {}), "");
  EXPECT_THAT(fault_with([](FreeBody& b) { b.mass = 0.0; }), HasSubstr("mass"));
  EXPECT_THAT(fault_with([](FreeBody& b) { b.inertia(0, 0) = 5e-6; }), HasSubstr("no solid"));
  EXPECT_THAT(fault_with([](FreeBody& b) { b.inertia(0, 0) = -1e-6; }), HasSubstr("no solid"));
  EXPECT_THAT(fault_with([](FreeBody& b) { b.inertia(0, 1) = 1e-6; }), HasSubstr("no inertia"));
  EXPECT_THAT(fault_with([](FreeBody& b) { b.joint.axis *= 2.0; }), HasSubstr("axis"));
  EXPECT_THAT(fault_with([](FreeBody& b) { b.joint.low = 0.1; }), HasSubstr("limits"));
  EXPECT_THAT(fault_with([](FreeBody& b) { b.joint.damping = -1.0; }), HasSubstr("spring"));
}

}  // namespace
}  // namespace palpate
