#include "scenes/scene_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/mesh/units.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "server/physics/limits.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

MeshReport BoxReport(double side) {
  return InspectMesh(MakeBox(Vec3::Constant(side)));
}

Coverage Bare(double p99) {
  Coverage coverage;
  coverage.uncovered.p99 = p99;
  return coverage;
}

TEST(SceneVerdict, SaysWhatANumberShouldBe) {
  const MeshReport box = BoxReport(0.1);
  EXPECT_DOUBLE_EQ(AllowedGap(box), 0.001);
  EXPECT_EQ(ToText(JudgeCoverage("object cheek", box, Bare(0.001), 64)),
            "verdict: good to touch\n");
  const Verdict limited = JudgeCoverage("object cheek", box, Bare(0.002), 64);
  EXPECT_TRUE(limited.usable());
  EXPECT_EQ(
      ToText(limited),
      "verdict: usable with these limits:\n"
      "  - object cheek: 1 % of its surface is outside its spheres by more than 2 mm, which "
      "should be at most 1 mm; the tool sinks in that far there: give it more than 64 leaves\n");
}

TEST(SceneVerdict, WhereTheToolFallsInTheSceneIsNotUsable) {
  const Verdict verdict = JudgeCoverage("object cheek", BoxReport(0.1), Bare(0.011), 2);
  EXPECT_FALSE(verdict.usable());
  EXPECT_THAT(ToText(verdict),
              HasSubstr("verdict: not usable:\n  - object cheek: 1 % of its surface"));
}

TEST(SceneVerdict, SpheresThatStickOutAreALimit) {
  Coverage coverage;
  coverage.outside.p99 = 0.003;
  EXPECT_THAT(JudgeCoverage("tool probe", BoxReport(0.1), coverage, 64).limits,
              ElementsAre(HasSubstr(
                  "tool probe: 1 % of its spheres' surface sticks out by more than 3 mm")));
}

TEST(SceneVerdict, MeshThatIsRefusedIsAFaultAndARemarkALimit) {
  TriangleMesh open = MakeBox(Vec3::Ones());
  open.triangles.pop_back();
  EXPECT_THAT(JudgeMesh("mesh", InspectMesh(open)).limits,
              ElementsAre(HasSubstr("mesh: 3 edges are open")));
  EXPECT_THAT(JudgeMesh("mesh", InspectMesh({})).faults, ElementsAre(HasSubstr("no triangles")));
  EXPECT_THAT(JudgeMesh("mesh", BoxReport(1.0)).limits, IsEmpty());
}

TEST(SceneVerdict, SpheresAreFeltWhereSomethingYieldsOrTheContactIsOfSpheres) {
  Scene scene;
  scene.objects.resize(2);
  scene.tools.resize(1);
  Body& tool = scene.tools[0];
  tool.mesh = MakeBox(Vec3::Constant(0.01));
  tool.tree = BuildSphereTree(tool.mesh, 8);
  EXPECT_FALSE(FeltBySpheres(scene, scene.objects[0], false));
  EXPECT_FALSE(FeltBySpheres(scene, tool, true));
  scene.objects[1].materials[0].stiffness = 500.0;
  EXPECT_FALSE(FeltBySpheres(scene, scene.objects[0], false));
  EXPECT_TRUE(FeltBySpheres(scene, scene.objects[1], false));
  EXPECT_TRUE(FeltBySpheres(scene, tool, true));
  scene.features.contact = ContactModel::kSpheres;
  EXPECT_TRUE(FeltBySpheres(scene, scene.objects[0], false));
  tool.tree = SingleSphereTree(tool.mesh, {Vec3::Zero(), 0.005});
  EXPECT_FALSE(FeltBySpheres(scene, tool, true));
}

Scene BallOn(const TriangleMesh& mesh, std::size_t leaves) {
  Scene scene;
  Body ball{"ball", MakeSphere(0.005, 20), {}, {}};
  ball.tree = SingleSphereTree(ball.mesh, {Vec3::Zero(), 0.005});
  Body object{"object", mesh, {}, {}};
  object.tree = BuildSphereTree(mesh, leaves);
  scene.tools = {ball};
  scene.objects = {object};
  return scene;
}

TEST(SceneVerdict, OfAGoodSceneIsGood) {
  EXPECT_EQ(ToText(JudgeScene(BallOn(MakeBox(Vec3::Constant(0.05)), 64))),
            "verdict: good to touch\n");
}

TEST(SceneVerdict, OfSpheresWithoutRadiusIsNotUsable) {
  Scene scene = BallOn(MakeBox(Vec3::Constant(0.05)), 64);
  scene.objects[0].tree.leaf_radius[7] = 0.0;
  const Verdict verdict = JudgeScene(scene);
  EXPECT_FALSE(verdict.usable());
  EXPECT_THAT(ToText(verdict), HasSubstr("1 of its 64 spheres have no radius"));
}

TEST(SceneVerdict, SaysThatABodyIsOfAnUnusualSize) {
  for (const double side : {1000.0, 1e-9}) {
    EXPECT_THAT(JudgeScene(BallOn(MakeBox(Vec3::Constant(side)), 64)).limits,
                ElementsAre(HasSubstr("an unusual size")))
        << side;
  }
}

TEST(SceneVerdict, SaysThatABodyIsTooSmallForWhatContactKeepsApart) {
  EXPECT_DOUBLE_EQ(kShortestByMesh, 100.0 * limits::mesh::kSeparation);
  EXPECT_THAT(std::string(kTooShortByMesh),
              AllOf(HasSubstr("0.001 mm apart"), HasSubstr("0.1 mm")));
  const auto limits_of = [](double side, ContactModel contact) {
    Scene scene = BallOn(MakeBox(Vec3::Constant(side)), 64);
    scene.features.contact = contact;
    return JudgeScene(scene).limits;
  };
  EXPECT_THAT(limits_of(1.01e-4, ContactModel::kSurface), IsEmpty());
  EXPECT_THAT(limits_of(1e-5, ContactModel::kSurface),
              ElementsAre(AllOf(HasSubstr("object object: its longest side is 0.01 mm"),
                                HasSubstr("0.001 mm apart"))));
  Scene small = BallOn(MakeBox(Vec3::Constant(1e-5)), 64);
  small.features.contact = ContactModel::kSurface;
  small.tuning.separation = 1e-8;
  EXPECT_THAT(JudgeScene(small).limits, ElementsAre(Not(HasSubstr("mm apart"))));
  EXPECT_THAT(limits_of(1e-5, ContactModel::kSpheres), Not(Contains(HasSubstr("apart"))));
}

}  // namespace
}  // namespace palpate
