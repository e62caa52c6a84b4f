// Random hands over small scenes: what currently holds for each contact model.
#include "tests/support/hand_trial.h"

#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/fmt/fmt.h>

#include "scenes/catalogue.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/program.h"
#include "tests/support/sharp_bodies.h"
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

/// A hand's poses, one row `x,y,z,qw,qx,qy,qz` per millisecond, from paths/NAME.csv.gz.
std::vector<Pose> PathNamed(const std::string& name) {
  Program unpacked("/bin/gzip",
                   {"-dc", PALPATE_SOURCE_DIR "/tests/support/paths/" + name + ".csv.gz"});
  EXPECT_EQ(unpacked.Exit(), 0) << unpacked.Output();
  std::istringstream rows(unpacked.Output());
  std::vector<Pose> poses;
  Pose X;
  char comma;
  while (rows >> X.p.x() >> comma >> X.p.y() >> comma >> X.p.z() >> comma >> X.q.w() >> comma >>
         X.q.x() >> comma >> X.q.y() >> comma >> X.q.z()) {
    poses.push_back(X);
  }
  return poses;
}

// Hands that stand still where a tool once lagged for good, with half of its force or none.
TEST(HandTrial, BunniesArriveWhereTheHandStandsStillAndFeelWhatHoldsThem) {
  Scene scene = LoadScene("bunny-bunny");
  scene.features.contact = ContactModel::kSurface;
  const struct {
    const char* path;
    std::size_t still;  ///< the hand, from this row on
    double force;       ///< [N]
  } hands[] = {{"bunny-64", 64, 2.34}, {"bunny-4935", 4935, 1.56}};
  for (const auto& hand : hands) {
    const std::vector<Pose> X_WH = PathNamed(hand.path);
    ASSERT_EQ(X_WH.size(), hand.still + 1001) << hand.path;
    std::vector<StepReport> reports;
    const ContactFigures figures = MeasureContact(
        scene, X_WH, {.oracle_every = 200, .converge_every = 0, .hold_far = true}, &reports);
    EXPECT_EQ(BrokenLimits(figures, {.meeting_fraction = 0.0, .stuck = 0}), "") << hand.path;
    for (std::size_t i = hand.still; i < reports.size(); ++i) {
      ASSERT_NEAR(reports[i].wrench.force.norm(), hand.force, 0.01) << hand.path << ", step " << i;
      ASSERT_EQ(reports[i].faults, kFaultNone) << hand.path << ", step " << i;
    }
  }
}

// How often the tool arrives is printed, but not judged.
TEST(HandTrial, SharpEdgesStayOutAndAreFeltByAHandThatPressesOn) {
  for (const std::string_view name : kSharpScenes) {
    const Scene scene = *MakeSharpScene(std::string(name) + ":23");
    const ContactFigures figures = MeasureContact(
        scene, MakeHand(scene, {.seed = 40961, .speed = 0.1, .steps = 1500, .press_mm = 15.0}),
        {.oracle_every = 1, .converge_every = 0, .hold_far = true});
    EXPECT_EQ(BrokenLimits(figures, {.meeting_fraction = 0.0, .depth = 0.0, .stuck = 0}), "")
        << name;
    EXPECT_GT(figures.force_rms, 0.1) << name << ": the hand never pressed";
    fmt::print("{}: {} of {} steps did not arrive, {} never do; {} notches\n", name,
               figures.steps - figures.arrived, figures.steps, figures.held.never,
               figures.force.notches.size());
  }
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
