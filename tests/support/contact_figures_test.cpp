#include "tests/support/contact_figures.h"

#include <algorithm>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/shapes/shapes.h"
#include "server/physics/scene_model.h"
#include "tests/support/test_scenes.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

/// A ball of 5 mm on a cube of 50 mm, in contact as surfaces: everything is known.
Scene BallOnCube() {
  return MakeScene(MakeSphere(0.005, 320), 1, MakeBox(Vec3::Constant(0.05)), 256,
                   ContactModel::kSurface);
}

/// Descends to 1 mm inside the top face at `speed` mm/ms, and stays there.
std::vector<Pose> Descent(double speed_mm, int steps) {
  std::vector<Pose> hand;
  for (int i = 0; i < steps; ++i) {
    hand.push_back({Vec3(0.003, std::max(0.029, 0.032 - 1e-3 * speed_mm * i), 0.004)});
  }
  return hand;
}

TEST(ContactFigures, AreThoseOfABallOnACube) {
  const ContactFigures f = MeasureContact(
      BallOnCube(), Descent(0.1, 100), {.settle_every = 10, .quarter_steps = true, .progress = {}});
  EXPECT_EQ(f.steps, 100u);
  EXPECT_TRUE(f.finite);
  EXPECT_EQ(f.arrived_fraction(), 1.0);
  EXPECT_EQ(f.depth.size(), 100u);
  EXPECT_LT(*std::max_element(f.depth.begin(), f.depth.end()), 1e-12);
  EXPECT_TRUE(f.lag.empty());
  EXPECT_EQ(f.force_error.size(), 100u);
  EXPECT_LT(*std::max_element(f.force_error.begin(), f.force_error.end()), 1e-9);
  EXPECT_EQ(f.settling.poses, 10u);
  EXPECT_EQ(f.settling.within_10ms, 10u);
  EXPECT_LT(f.force_4khz_rms_fraction, 1e-9);
  EXPECT_NEAR(f.force.largest_jump.size, 0.1, 1e-9) << "1 N/mm and 0.1 mm a step";
  EXPECT_NEAR(f.mean_speed, 3.0 / 99.0, 1e-9);
  EXPECT_EQ(BrokenLimits(f, {.depth = 1e-9,
                             .arrived_fraction = 1.0,
                             .jump = 0.11,
                             .unexplained = 0,
                             .force_4khz = 0.01,
                             .settled_10ms = 1.0,
                             .settled_50ms = 1.0}),
            "");
}

/// A tool limited to one sub-step per cycle, half a millimetre, with a faster hand.
struct SlowTool {
  SlowTool(std::vector<Pose> hand_, const Pose& from) : hand(std::move(hand_)) {
    start.X_WG = start.X_WH = from;
  }
  ContactFigures Measure(const ContactChecks& checks) {
    return MeasureContact(ContactPath{scene, model, workspace, start, hand}, checks);
  }
  static StepParameters Slow(StepParameters parameters) {
    parameters.sub_steps = 1;
    return parameters;
  }

  Scene scene = BallOnCube();
  HapticModel model{scene.tools[0].tree, MakeObjects(scene),
                    Slow(MakeModel(scene, scene.tools[0], MakeObjects(scene)).parameters()),
                    &scene.tools[0].mesh};
  StepWorkspace workspace{model};
  StepState start{model};
  std::vector<Pose> hand;
};

TEST(ContactFigures, SeeAToolThatNeverArrivesThoughTheHandRests) {
  // At 0.5 mm per step the first distance takes 2,000 steps, the second 60.
  SlowTool tool({{Vec3(0.0, 1.0, 0.0)}, {Vec3(0.0, 0.03, 0.0)}}, {Vec3(0.0, 0.06, 0.0)});
  const ContactFigures f = tool.Measure({.hold_far = true, .progress = {}});
  EXPECT_EQ(f.steps - f.arrived, 2u);
  EXPECT_EQ(f.longest_behind, 2u);
  EXPECT_EQ(f.held.tried, 2u);
  EXPECT_EQ(f.held.never, 1u);
  EXPECT_EQ(f.held.first_step, 0u);
  EXPECT_EQ(f.held.without_force, 1u) << "in the air";
  EXPECT_EQ(f.held.stuck, 0u) << "it is on its way";
  ASSERT_EQ(f.held.steps_needed.size(), 1u);
  EXPECT_GT(f.held.median(), 50);
  EXPECT_LT(f.held.median(), 100);
  EXPECT_EQ(f.held.force_error, std::vector{0.0}) << "in the air";
  EXPECT_EQ(f.unconverged, 1u) << "the first";
  // Holding does not disturb the path itself.
  const ContactFigures unheld = tool.Measure({.progress = {}});
  EXPECT_EQ(unheld.held.tried, 0u);
  EXPECT_EQ(unheld.lag, f.lag);
}

TEST(ContactFigures, EveryLimitCanBreak) {
  ContactFigures f;
  f.steps = 10;
  f.arrived = 9;
  f.finite = false;
  f.depth = {0.0, 2e-6};
  f.meeting = 1;
  f.deepest_step = 7;
  f.held.never = f.held.stuck = 1;
  f.force.notches.push_back({.begin = 3, .end = 5});
  f.force.largest_jump = {.step = 4, .size = 2.0};
  f.jumps.count[static_cast<std::size_t>(JumpCause::kUnexplained)] = 3;
  f.jumps.force[static_cast<std::size_t>(JumpCause::kUnexplained)] = 2.0;
  f.force_4khz_rms_fraction = 0.2;
  f.settling = {.poses = 4, .within_10ms = 2, .within_50ms = 3};
  const std::string broken = BrokenLimits(f, {.meeting_fraction = 0.4,
                                              .depth = 1e-6,
                                              .arrived_fraction = 0.95,
                                              .never_arrived = 0,
                                              .stuck = 0,
                                              .notches = 0,
                                              .jump = 1.0,
                                              .unexplained = 2,
                                              .force_4khz = 0.1,
                                              .settled_10ms = 0.5,
                                              .settled_50ms = 0.8});
  EXPECT_EQ(std::count(broken.begin(), broken.end(), '\n'), 11) << broken;
  EXPECT_THAT(broken, HasSubstr("step 7"));
  f.finite = true;
  EXPECT_EQ(BrokenLimits(f, {}), "") << "the defaults let everything pass";
}

}  // namespace
}  // namespace palpate::test
