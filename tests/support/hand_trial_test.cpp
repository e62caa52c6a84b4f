// Hands that nobody tuned to over small scenes: what holds today of each model of contact.
#include "tests/support/hand_trial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/catalogue.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/test_scenes.h"

namespace palpate::test {
namespace {

Scene BoxOnBox() {
  return MakeScene(MakeBox(Vec3(0.03, 0.02, 0.04)), 256, MakeBox(Vec3(0.06, 0.05, 0.04)), 512,
                   ContactModel::kSpheres);
}

Scene BallOnEllipsoid() {
  return MakeScene(MakeSphere(0.015, 320), 128, MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280), 512,
                   ContactModel::kSpheres);
}

/// A ball of 5 mm, three degrees of freedom, on a cube.
Scene Cube(ContactModel contact) {
  Scene scene = LoadScene("cube");
  scene.features.contact = contact;
  return scene;
}

TEST(HandTrial, SpheresArriveWithoutJumpsThatNothingExplains) {
  HandTrial trial;
  trial.limits = {.arrived_fraction = 0.98, .unexplained = 0};
  EXPECT_EQ(TryHands(BoxOnBox(), trial), "");
  EXPECT_EQ(TryHands(BallOnEllipsoid(), trial), "");
  EXPECT_EQ(TryHands(Cube(ContactModel::kSpheres), trial), "");
}

TEST(HandTrial, ABallOnACubesSurfaceStaysOutArrivesAndSettles) {
  HandTrial trial;
  trial.limits = {.depth = 1e-6, .arrived_fraction = 0.99, .unexplained = 0, .settled_50ms = 1.0};
  EXPECT_EQ(TryHands(Cube(ContactModel::kSurface), trial), "");
}

TEST(HandTrial, NamesTheSeedThatFails) {
  HandTrial trial;
  trial.first_seed = trial.last_seed = 3;
  trial.steps = 500;
  trial.limits.arrived_fraction = 1.1;
  EXPECT_THAT(TryHands(Cube(ContactModel::kSpheres), trial),
              testing::StartsWith("seed 3 at 0.1 m/s, 500 steps:\nthe tool arrived in 500 of 500"));
}

}  // namespace
}  // namespace palpate::test
