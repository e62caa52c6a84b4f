#include "tests/support/support_figures.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "scenes/shapes/shapes.h"
#include "server/physics/scene_model.h"
#include "tests/support/contact_figures.h"
#include "tests/support/test_scenes.h"

namespace palpate::test {
namespace {

/// Presses the tool, above the origin, 2 mm into what is below, and then keeps still.
std::vector<Pose> Press(double y) {
  std::vector<Pose> hand;
  for (int i = 0; i < 60; ++i)
    hand.push_back({Vec3(0.003, y + 1e-4 * std::max(-20, 5 - i), 0.004)});
  return hand;
}

SupportFigures Measure(const Scene& scene, double y) {
  return MeasureContact(scene, Press(y), {.judge_every = 1, .progress = {}}).support;
}

TEST(SupportFigures, FindABlockOnACubeBorneAndNotToBeNudgedAway) {
  const SupportFigures s =
      Measure(MeshScene(MakeBox(Vec3::Constant(0.01)), MakeBox(Vec3::Constant(0.05))), 0.03);
  EXPECT_EQ(s.not_judged_for, "");
  EXPECT_EQ(s.force.size(), 60u);
  EXPECT_LT(std::ranges::max(s.force), 1e-4);
  EXPECT_LT(std::ranges::max(s.torque), 1e-5);
  EXPECT_GT(s.nudged, 40u);
  EXPECT_EQ(s.freed, 0u);
}

TEST(SupportFigures, FindABallOnACubeBorne) {
  Scene scene = MeshScene(MakeBox(Vec3::Constant(0.01)), MakeBox(Vec3::Constant(0.05)));
  scene.tools.front() = BallBody(0.005);
  const SupportFigures s = Measure(scene, 0.03);
  EXPECT_LT(std::ranges::max(s.force), 1e-4);
  EXPECT_GT(s.nudged, 40u);
}

TEST(SupportFigures, DoNotJudgeLeaves) {
  Scene scene = MeshScene(MakeBox(Vec3::Constant(0.01)), MakeBox(Vec3::Constant(0.05)));
  scene.features.contact = ContactModel::kSpheres;
  const SupportFigures s = Measure(scene, 0.03);
  EXPECT_NE(s.not_judged_for, "");
  EXPECT_TRUE(s.force.empty());
  EXPECT_EQ(s.nudged, 0u);
}

TEST(SupportFigures, DoNotJudgeWhatYields) {
  Scene scene = MakeScene(MakeBox(Vec3::Constant(0.01)), 64, MakeBox(Vec3::Constant(0.05)), 256,
                          ContactModel::kSurface);
  scene.features.compliance = true;
  scene.objects.front().materials.front().stiffness = 300.0;
  const SupportFigures s = Measure(scene, 0.03);
  EXPECT_GT(s.soft, 30u);
  EXPECT_LT(s.force.size(), 30u);
}

/// What the step says of a block that stands where nothing holds it sideways: the judge takes the
/// poses' pull and not the step's word.
TEST(SupportFigures, TakeAnArrivedToolThatNothingHoldsAtItsPull) {
  const Scene scene = MeshScene(MakeBox(Vec3::Constant(0.01)), MakeBox(Vec3::Constant(0.05)));
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  StepWorkspace workspace(model);
  SupportMeasure measure(scene, model, workspace);
  StepState state(model);
  state.X_WG.p = {0.0, 0.03 + 1e-6, 0.0};
  StepReport report{};
  report.X_WG = state.X_WG;
  const Pose X_WH{state.X_WG.p + Vec3(0.005, -0.002, 0.0)};
  measure.Judge(7, X_WH, report, state);
  ASSERT_EQ(measure.figures().force.size(), 1u);
  EXPECT_NEAR(measure.figures().force.front(), 5.0, 1e-4) << "1 N/mm";
  EXPECT_EQ(measure.figures().worst_step, 7u);
  EXPECT_EQ(measure.figures().freed, 1u) << "the step itself goes where the pull is borne";
  EXPECT_EQ(measure.figures().freed_unnudged, 1u);
  report.faults = kFaultTargetFar;
  measure.Judge(8, X_WH, report, state);
  EXPECT_EQ(measure.figures().force.size(), 1u) << "not arrived";
}

// A block is drawn sideways by a little less than static friction holds.  A nudge that makes it
// slip costs what static friction held beyond dynamic friction.
TEST(SupportFigures, TellStictionThatANudgeBreaksFromWhatNothingHolds) {
  Scene scene = MeshScene(MakeBox(Vec3::Constant(0.01)), MakeBox(Vec3::Constant(0.05)));
  scene.features.friction = FrictionModel::kCoulomb;
  scene.objects.front().materials.front().static_friction = 0.5;
  scene.objects.front().materials.front().dynamic_friction = 0.3;
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  StepWorkspace workspace(model);
  SupportMeasure measure(scene, model, workspace);
  StepState state(model);
  state.X_WG.p = {0.0, 0.03 + 2e-6, 0.0};
  Pose X_WH = state.X_WG;
  StepReport report{};
  for (int i = 0; i < 300; ++i) {
    X_WH.p.y() = 0.03 - 1e-3 * std::min(1.0, 0.01 * i);
    X_WH.p.x() = 0.4985e-3 * std::clamp(0.01 * (i - 150), 0.0, 1.0);
    report = HapticStep(model, X_WH, state, workspace);
  }
  for (std::size_t step = 0; step < 20; ++step) measure.Judge(step, X_WH, report, state);
  const SupportFigures& s = measure.figures();
  EXPECT_EQ(s.nudged, 20u);
  EXPECT_GT(s.freed, 3u);
  EXPECT_EQ(s.freed_of_stiction, s.freed);
  EXPECT_EQ(s.freed_unnudged, 0u);
}

TEST(SupportFigures, CountCyclesWhoseFrictionFailed) {
  const Scene scene = MeshScene(MakeBox(Vec3::Constant(0.01)), MakeBox(Vec3::Constant(0.05)));
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  StepWorkspace workspace(model);
  SupportMeasure measure(scene, model, workspace);
  StepReport report{};
  report.diagnostics.friction_unsolved = 3;
  measure.Count(report);
  report.diagnostics = {};
  report.diagnostics.friction_yielded = 1;
  measure.Count(report);
  EXPECT_EQ(measure.figures().friction_unsolved, 1u);
  EXPECT_EQ(measure.figures().friction_yielded, 1u);
}

}  // namespace
}  // namespace palpate::test
