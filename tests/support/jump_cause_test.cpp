#include "tests/support/jump_cause.h"

#include <cstdint>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "server/physics/scene_model.h"
#include "tests/support/test_scenes.h"

namespace palpate::test {
namespace {

/// Two successive steps of a tool 100 mm long on a spring of 1 N/mm and 1 N m.
class JumpCauseTest : public testing::Test {
 protected:
  JumpCauseTest()
      : scene_(MakeScene(MakeBox(Vec3(0.1, 0.02, 0.02)), 64, MakeBox(Vec3::Constant(0.1)), 64,
                         ContactModel::kSpheres)),
        model_(MakeModel(scene_, scene_.tools.front(), MakeObjects(scene_))),
        judge_(scene_, model_) {
    before_.contacts = after_.contacts = 1;
    for (StepReport* report : {&before_, &after_}) {
      report->active[0].id = {ContactId::kLeaves, 3, 4};
      report->active[0].normal = Vec3::UnitY();
      report->wrench.force.y() = 2.0;
    }
  }
  void Jump(double newtons) { after_.wrench.force.y() = before_.wrench.force.y() + newtons; }
  JumpCause Cause() const { return judge_.Judge(X_WH_before_, before_, X_WH_, after_); }

  Scene scene_;
  HapticModel model_;
  JumpJudge judge_;
  Pose X_WH_before_, X_WH_;
  StepReport before_{}, after_{};  // of zeros: rows are not initialised
};

TEST_F(JumpCauseTest, IsNoneForAForceThatHardlyChanges) {
  Jump(kJump);
  EXPECT_EQ(Cause(), JumpCause::kNone);
  Jump(NAN);
  EXPECT_EQ(Cause(), JumpCause::kUnexplained);
}

TEST_F(JumpCauseTest, IsTheHandWhereTheSpringDoesNoMoreThanItWasMoved) {
  Jump(0.8);
  X_WH_.p.y() = -0.4e-3;
  EXPECT_EQ(Cause(), JumpCause::kHand) << "2 x 1 N/mm x 0.4 mm";
  X_WH_.p.y() = -0.39e-3;
  EXPECT_EQ(Cause(), JumpCause::kUnexplained);
  // A turn of 0.02 rad is 0.63 mm: sqrt(k_r / k_t) = 31.6 mm.
  X_WH_ = {Vec3::Zero(), RotationExp(Vec3(0, 0, 0.02))};
  EXPECT_EQ(Cause(), JumpCause::kHand);
  X_WH_.q = RotationExp(Vec3(0, 0, 0.012));
  EXPECT_EQ(Cause(), JumpCause::kUnexplained);
}

TEST_F(JumpCauseTest, IsUnexplainedWhereTheSameContactsHold) {
  Jump(-0.6);
  EXPECT_EQ(Cause(), JumpCause::kUnexplained);
  // Another pair at the same place, such as the next triangle, is the same contact.
  after_.active[0].id = {ContactId::kLeaves, 5, 6};
  after_.active[0].contact_W.x() = 0.3e-3;
  EXPECT_EQ(Cause(), JumpCause::kUnexplained);
}

TEST_F(JumpCauseTest, IsUnexplainedWhereTheSpringIsStretchedByNobody) {
  // A contact that is new to an arrived tool adds no more force than the hand demands.
  Jump(0.6);
  after_.contacts = 2;
  after_.active[1].contact_W.x() = 0.02;
  EXPECT_EQ(Cause(), JumpCause::kUnexplained);
  after_.X_WG.p.x() = 1e-3;
  EXPECT_EQ(Cause(), JumpCause::kUnexplained) << "no snap goes uphill";
  after_.X_WG = {};
  before_.faults = kFaultTargetFar;
  EXPECT_EQ(Cause(), JumpCause::kGained) << "a tool that was behind meets what the hand has passed";
}

TEST_F(JumpCauseTest, IsAContactThatCameOrWent) {
  Jump(-0.6);
  after_.contacts = 2;
  after_.active[1].id = {ContactId::kLeaves, 7, 8};
  after_.active[1].contact_W.x() = 0.02;
  after_.active[1].normal = Vec3::UnitY();
  EXPECT_EQ(Cause(), JumpCause::kGained);
  before_.contacts = 2;
  before_.active[1] = after_.active[1];
  after_.contacts = 1;
  EXPECT_EQ(Cause(), JumpCause::kLost);
  // At the same place but at a steep angle to it: another contact.
  before_.contacts = 1;
  after_.active[0].id = {ContactId::kLeaves, 5, 6};
  after_.active[0].normal = Vec3(1, 1, 0).normalized();
  EXPECT_EQ(Cause(), JumpCause::kGained);
}

TEST_F(JumpCauseTest, IsALedgeWhereTheGraphicToolSnapsTowardsTheHand) {
  Jump(-0.6);
  X_WH_.p.x() = 1e-4;
  after_.X_WG.p.x() = 2.9e-4;
  EXPECT_EQ(Cause(), JumpCause::kUnexplained);
  after_.X_WG.p.x() = 3.1e-4;
  EXPECT_EQ(Cause(), JumpCause::kUnexplained) << "no nearer to the hand than it was";
  X_WH_before_.p.y() = X_WH_.p.y() = -2e-3;
  EXPECT_EQ(Cause(), JumpCause::kLedge) << "over a bump, with the same contact";
  // The hand moves on, so the stretch grows to 2.18 mm, but by less than if the tool had stayed.
  after_.wrench.force = Vec3(0.6, 2.1, 0.0);
  after_.X_WG.p.x() = 0.7e-3;
  X_WH_before_.p.y() = -1.95e-3;
  X_WH_.p = Vec3(0.0, -2.15e-3, 0.0);
  EXPECT_EQ(Cause(), JumpCause::kUnexplained) << "2.15 mm, had it stayed";
  X_WH_before_.p.y() = -2e-3;
  X_WH_.p.y() = -2.2e-3;
  EXPECT_EQ(Cause(), JumpCause::kLedge);
  before_.faults = kFaultTargetFar;
  EXPECT_EQ(Cause(), JumpCause::kUnexplained) << "it was only behind";
  after_.contacts = 0;
  EXPECT_EQ(Cause(), JumpCause::kLedge);
  after_.X_WG.p.x() = 2.9e-4;
  EXPECT_EQ(Cause(), JumpCause::kLost);
}

TEST_F(JumpCauseTest, IsFrictionThatLetsGo) {
  Jump(-0.6);
  before_.active[0].friction = Vec3(0.8, 0, 0);
  after_.active[0].friction = Vec3(0.3, 0, 0);
  EXPECT_EQ(Cause(), JumpCause::kLetGo);
  after_.active[0].friction = Vec3(0.7, 0, 0);
  EXPECT_EQ(Cause(), JumpCause::kUnexplained);
}

}  // namespace
}  // namespace palpate::test
