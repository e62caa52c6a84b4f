#include "server/offer/generated_hand.h"

#include <algorithm>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "scenes/shapes/shapes.h"
#include "server/physics/haptic_step.h"
#include "server/physics/scene_model.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/test_scenes.h"

namespace palpate::test {
namespace {

/// A tool over or in a box of 40 x 20 x 30 units of `mm`.
Scene OverABox(TriangleMesh tool, std::size_t leaves, const Vec3& start_mm, double mm = 1e-3) {
  Scene scene = MakeScene(std::move(tool), leaves, MakeBox(mm * Vec3(40, 20, 30)), 256,
                          ContactModel::kSurface);
  scene.tools[0].X_WB.p = mm * start_mm;
  return scene;
}

Scene BallOverABox(const Vec3& start_mm, double mm = 1e-3) {
  Scene scene = OverABox(MakeSphere(2.0 * mm, 320), 64, start_mm, mm);
  scene.tools[0].tree = SingleSphereTree(scene.tools[0].mesh, {Vec3::Zero(), 2.0 * mm});
  return scene;
}

std::optional<PoseScript> HandOf(const Scene& scene, std::uint64_t seed = 1) {
  return MakeHandFor(scene, scene.tools[0], MakeModel(scene, scene.tools[0], MakeObjects(scene)),
                     seed);
}

/// What a hand that follows the script exactly feels.
struct Felt {
  double force_N_max = 0.0;
  double contact_s = 0.0;
  double way_in_contact_m = 0.0;  ///< of the graphic tool
};
Felt Play(const Scene& scene, const PoseScript& script) {
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  StepWorkspace workspace(model);
  StepState state(model);
  state.X_WG = state.X_WH = script.At(0.0);
  Felt felt;
  Vec3 before = state.X_WG.p;
  for (double t = 0.0; t <= script.duration(); t += 1e-3) {
    const StepReport report = HapticStep(model, script.At(t), state, workspace);
    if (report.contacts > 0) {
      felt.contact_s += 1e-3;
      felt.way_in_contact_m += (report.X_WG.p - before).norm();
    }
    felt.force_N_max = std::max(felt.force_N_max, report.wrench.force.norm());
    before = report.X_WG.p;
  }
  return felt;
}

const PoseScript::Key& KeyOf(const PoseScript& script, const std::string& label) {
  return *std::ranges::find(script.keys(), label, &PoseScript::Key::label);
}

TEST(GeneratedHand, ComesToTheNearestFacePressesSlidesAndLifts) {
  const Scene scene = BallOverABox({3, 30, -4});
  const std::optional<PoseScript> hand = HandOf(scene);
  ASSERT_TRUE(hand);
  // Starts and ends, free of contact, where the scene places the tool.
  EXPECT_NEAR((hand->At(0.0).p - Vec3(0.003, 0.030, -0.004)).norm(), 0.0, 1e-12);
  EXPECT_EQ(hand->At(0.0).p, hand->keys().back().X_WH.p);
  EXPECT_FALSE(MeshOracle(scene).Meet(hand->At(0.0)));
  // The top face is y = 10 mm, the ball's radius 2 mm.
  const Pose& touching = KeyOf(*hand, "press").X_WH;
  EXPECT_NEAR((touching.p - Vec3(0.003, 0.012, -0.004)).norm(), 0.0, 2e-5);
  const Pose& pressed = KeyOf(*hand, "slide").X_WH;
  EXPECT_NEAR((pressed.p - Vec3(0.003, 0.009, -0.004)).norm(), 0.0, 2e-5);
  for (const PoseScript::Key& key : hand->keys()) {
    if (key.label == "slide") {
      EXPECT_NEAR(key.X_WH.p.y(), 0.009, 2e-5) << key.t;
    }
  }
  const Felt felt = Play(scene, *hand);
  EXPECT_NEAR(felt.force_N_max, 3.0, 0.1);
  EXPECT_GT(felt.way_in_contact_m, 2 * 0.9 * 0.2 * 0.040) << "a fifth of the box, and back";
  EXPECT_LT(felt.contact_s, hand->duration() - 2.0);
}

TEST(GeneratedHand, IsTheSameForTheSameSeedAndSlidesElsewhereForAnother) {
  const Scene scene = BallOverABox({0, 30, 0});
  const std::vector<PoseScript::Key> one = HandOf(scene, 1)->keys(),
                                     again = HandOf(scene, 1)->keys(),
                                     two = HandOf(scene, 2)->keys();
  ASSERT_EQ(one.size(), again.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].t, again[i].t);
    EXPECT_EQ(one[i].X_WH.p, again[i].X_WH.p);
    EXPECT_EQ(one[i].X_WH.q.coeffs(), again[i].X_WH.q.coeffs());
  }
  const std::size_t middle = one.size() / 2;
  EXPECT_GT((one[middle].X_WH.p - two[middle].X_WH.p).norm(), 1e-3);
}

TEST(GeneratedHand, ComesFromOutsideWhereTheSceneHasTheToolInAnObject) {
  const Scene scene = BallOverABox({1, 2, 0});
  const std::optional<PoseScript> hand = HandOf(scene);
  ASSERT_TRUE(hand);
  const MeshOracle oracle(scene);
  EXPECT_GT(oracle.Distance(hand->At(0.0)).distance, 0.002);
  EXPECT_GT(Play(scene, *hand).contact_s, 2.0);
}

TEST(GeneratedHand, BringsAToolThatIsAMesh) {
  const Scene scene = OverABox(MakeBox(Vec3(0.006, 0.030, 0.004)), 64, {50, 12, 0});
  const std::optional<PoseScript> hand = HandOf(scene);
  ASSERT_TRUE(hand);
  EXPECT_FALSE(MeshOracle(scene).Meet(hand->At(0.0)));
  const Felt felt = Play(scene, *hand);
  EXPECT_GT(felt.force_N_max, 1.0);
  EXPECT_LT(felt.force_N_max, 4.0);
  EXPECT_GT(felt.way_in_contact_m, 0.002);
}

TEST(GeneratedHand, IsInProportionForTheVerySmallAndTheVeryLarge) {
  for (const double mm : {2e-5, 0.1}) {
    const Scene scene = BallOverABox({0, 30, 0}, mm);
    const std::optional<PoseScript> hand = HandOf(scene);
    ASSERT_TRUE(hand) << mm;
    const double size = 40.0 * mm;
    const double scale = size < 0.01 ? size / 0.01 : size;
    const double down = KeyOf(*hand, "press").X_WH.p.y() - KeyOf(*hand, "slide").X_WH.p.y();
    EXPECT_NEAR(down, 0.003 * scale, 0.0001 * scale) << mm;
  }
}

TEST(GeneratedHand, IsNoneWhereThereIsNothingToTouch) {
  const Scene scene = BallOverABox({0, 30, 0});
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  Scene bare = scene;
  bare.objects[0].mesh = {};
  EXPECT_FALSE(MakeHandFor(bare, bare.tools[0], model, 1));
}

}  // namespace
}  // namespace palpate::test
