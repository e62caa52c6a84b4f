#include "devices/simulated/simulated_hand.h"

#include <gtest/gtest.h>

#include "common/math/rotation.h"

namespace palpate {
namespace {

SimulatedHand Holding(const Pose& where) {
  return SimulatedHand(ScriptPlayer(PoseScript({{0.0, where, ""}, {1.0, where, ""}}), false),
                       HandImpedance{});
}

TEST(SimulatedHand, PullsTowardsItsScriptAsASpring) {
  Pose at;
  at.p = Vec3(0.01, 0.0, -0.02);
  at.q = RotationExp(Vec3(0.0, 0.3, 0.0));
  const SimulatedHand hand = Holding({});
  const Wrench pull = hand.WrenchOn(at, {}, 0.5);
  EXPECT_NEAR((pull.force - 135.0 * Vec3(-0.01, 0.0, 0.02)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((pull.torque - Vec3(0.0, -0.3, 0.0)).norm(), 0.0, 1e-12);
}

TEST(SimulatedHand, BrakesWhatMovesInIt) {
  const SimulatedHand hand = Holding({});
  const Wrench brake = hand.WrenchOn({}, {Vec3(0.1, 0, 0), Vec3(0, 0, 2.0)}, 0.5);
  EXPECT_NEAR(brake.force.x(), -0.645, 1e-12);
  EXPECT_NEAR(brake.torque.z(), -0.072, 1e-12);
}

TEST(SimulatedHand, DoesNotBrakeTheMovementThatItWants) {
  Pose there;
  there.p = Vec3(0.1, 0, 0);
  const ScriptPlayer script(PoseScript({{0.0, Pose{}, ""}, {1.0, there, ""}}), false);
  const SimulatedHand hand(script, HandImpedance{});
  const Wrench none = hand.WrenchOn(script.At(0.4), script.VelocityAt(0.4), 0.4);
  EXPECT_EQ(none.force, Vec3::Zero());
  EXPECT_EQ(none.torque, Vec3::Zero());
}

}  // namespace
}  // namespace palpate
