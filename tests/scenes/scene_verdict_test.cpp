#include "scenes/scene_verdict.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/tree/sphere_tree_builder.h"
#include "tests/scenes/support.h"
#include "tests/support/approved.h"

namespace palpate {
namespace {

MeshReport BoxReport(double side) {
  return InspectMesh(MakeBox(Vec3::Constant(side)));
}

Coverage Bare(double p99) {
  Coverage coverage;
  coverage.uncovered.p99 = p99;
  return coverage;
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

TEST(SceneVerdict, IsAsPeopleHaveApproved) {
  std::string said;
  const auto say = [&](const std::string& of, const Verdict& verdict) {
    said += "## " + of + "\n" + ToText(verdict);
  };
  const MeshReport box = BoxReport(0.1);
  EXPECT_DOUBLE_EQ(AllowedGap(box), 0.001);
  for (const double gap : {0.001, 0.002, 0.011}) {
    say("spheres that leave a gap", JudgeCoverage("object cheek", box, Bare(gap), 64));
  }
  Coverage coverage;
  coverage.outside.p99 = 0.003;
  say("spheres that stick out", JudgeCoverage("tool probe", box, coverage, 64));
  TriangleMesh open = MakeBox(Vec3::Ones());
  open.triangles.pop_back();
  say("an open mesh", JudgeMesh("mesh", InspectMesh(open)));
  say("a mesh of nothing", JudgeMesh("mesh", InspectMesh({})));
  say("a good mesh", JudgeMesh("mesh", BoxReport(1.0)));
  Scene scene = BallOn(MakeBox(Vec3::Constant(0.05)), 64);
  say("a good scene", JudgeScene(scene));
  scene.objects[0].tree.leaf_radius[7] = 0.0;
  say("a sphere without radius", JudgeScene(scene));
  for (const double side : {1000.0, 1.01e-4, 1e-5, 1e-9}) {
    say("a body of another size", JudgeScene(BallOn(MakeBox(Vec3::Constant(side)), 64)));
  }
  Scene small = BallOn(MakeBox(Vec3::Constant(1e-5)), 64);
  small.tuning.separation = 1e-8;
  say("a small body that may come nearer", JudgeScene(small));
  small.tuning = {};
  small.features.contact = ContactModel::kSpheres;
  say("a small body of spheres", JudgeScene(small));
  test::ExpectApproved("tests/scenes/scene_verdict.txt", said);
}

TEST(JudgeRest, NamesFreeBodiesThatOverlapWhereTheyArePlaced) {
  Scene scene;
  const auto box = [](const char* name, double x) {
    Body body{name, MakeBox(Vec3::Constant(0.01)), {}, {}};
    body.X_WB.p.x() = x;
    return body;
  };
  scene.objects = {box("table", 0.0), box("shelf", 0.004), box("block", 0.0098)};
  EXPECT_TRUE(JudgeRest(scene).faults.empty()) << "what stands still may overlap";
  scene.moved.push_back({.name = "block", .free = FreeBody{}});
  scene.objects[2].moved = 1;
  const std::vector<std::string> faults = JudgeRest(scene).faults;
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_THAT(faults[0], testing::HasSubstr("block and table: overlap by 0.2 mm"));
  EXPECT_THAT(faults[1], testing::HasSubstr("block and shelf: overlap by 4.2 mm"));
  scene.objects[2].X_WB.p.x() = 0.014001;
  EXPECT_TRUE(JudgeRest(scene).faults.empty());
}

}  // namespace
}  // namespace palpate
