#include "devices/limiter/passivity_observer.h"

#include <limits>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

TEST(PassivityObserver, SumsHeldWrenchTimesWay) {
  test::Random random(5);
  PassivityObserver observer;
  Pose X;
  observer.Move(X);
  double given = 0.0, highest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const Wrench held{random.InCube(3.0), random.InCube(0.1)};
    observer.Hold(held);
    const Vec3 step = random.InCube(1e-3), turn = random.InCube(1e-2);
    X = {X.p + step, (RotationExp(turn) * X.q).normalized()};
    if (i % 3 == 0) X.q.coeffs() *= -1.0;  // the same rotation
    observer.Move(X);
    given += held.force.dot(step) + held.torque.dot(turn);
    highest = std::max(highest, given);
  }
  EXPECT_NEAR(observer.energy_J(), -given, 1e-12);
  EXPECT_NEAR(observer.lowest_J(), -highest, 1e-12);
}

TEST(PassivityObserver, BooksNoWorkForALeapOrForTheFirstPose) {
  PassivityObserver observer;
  observer.Hold({Vec3(5, 0, 0), Vec3::Zero()});
  observer.Move({Vec3(0.3, 0, 0), Quat::Identity()});
  EXPECT_TRUE(observer.leapt());
  observer.Move({Vec3(0.4, 0, 0), Quat::Identity()});
  EXPECT_TRUE(observer.leapt());
  observer.Move({Vec3(0.4, 0, 0), RotationExp(Vec3(0, 1, 0))});
  EXPECT_TRUE(observer.leapt());
  EXPECT_EQ(observer.energy_J(), 0.0);
  observer.Move({Vec3(0.401, 0, 0), RotationExp(Vec3(0, 1, 0))});
  EXPECT_FALSE(observer.leapt());
  EXPECT_NEAR(observer.energy_J(), -5e-3, 1e-15);
}

TEST(PassivityObserver, PassesOverAPoseThatIsNoneAndBooksTheWayLater) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  PassivityObserver observer;
  observer.Move({});
  observer.Hold({Vec3(5, 0, 0), Vec3::Zero()});
  for (const Pose& none :
       {Pose{Vec3(kNan, 0, 0), Quat::Identity()}, Pose{Vec3(1e300, 0, 0), {}},
        Pose{Vec3::Zero(), Quat(0, 0, 0, 0)}, Pose{Vec3::Zero(), Quat(kNan, 0, 0, 0)}}) {
    observer.Move(none);
    EXPECT_FALSE(observer.seen());
  }
  observer.Move({Vec3(-0.002, 0, 0), Quat::Identity()});
  EXPECT_TRUE(observer.seen());
  EXPECT_NEAR(observer.energy_J(), 0.010, 1e-15);
}

}  // namespace
}  // namespace palpate
