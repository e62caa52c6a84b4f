#include "scenes/leaf_paint.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/catalogue.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "tests/scenes/support.h"
#include "tests/support/dirty_mesh.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;

Body BoxBody(const Vec3& size, std::size_t leaves) {
  Body body{"part", MakeBox(size), {}, {}};
  body.tree = BuildSphereTree(body.mesh, leaves);
  return body;
}

RegionDescription BoxRegion(const Vec3& low, const Vec3& high, double stiffness) {
  RegionDescription region;
  region.box = {low, high};
  region.material.material.stiffness = stiffness;
  region.where = "f.json:9: objects[0].regions[0]";
  return region;
}

Vec3 Centre(const SphereTree& tree, std::size_t i) {
  return {tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]};
}

TEST(LeafPaint, OneMaterialNeedsNoIndex) {
  Body body = BoxBody(Vec3(0.1, 0.1, 0.1), 100);
  BodyDescription description;
  description.material.material.static_friction = 0.5;
  PaintLeaves(description, {}, body);
  EXPECT_TRUE(body.leaf_material.empty());
  ASSERT_EQ(body.materials.size(), 1u);
  EXPECT_EQ(body.materials[0].static_friction, 0.5);
}

TEST(LeafPaint, LaterRegionsPaintOverEarlierOnes) {
  Body body = BoxBody(Vec3(0.1, 0.1, 0.1), 400);
  BodyDescription description;
  description.regions = {BoxRegion(Vec3(0, -1, -1), Vec3(1, 1, 1), 100), {}};
  RegionDescription& ball = description.regions[1];
  ball.kind = RegionDescription::Kind::kSphere;
  ball.ball = {Vec3(0.05, 0.05, 0.05), 0.04};
  ball.material.material.stiffness = 200;
  PaintLeaves(description, {}, body);
  ASSERT_EQ(body.leaf_material.size(), 400u);
  for (std::size_t i = 0; i < 400; ++i) {
    const Vec3 c = Centre(body.tree, i);
    const double expected = (c - ball.ball.centre).norm() <= 0.04 ? 200
                            : c.x() >= 0                          ? 100
                                                                  : INFINITY;
    EXPECT_EQ(body.materials[body.leaf_material[i]].stiffness, expected);
  }
}

/// Pressed all over a cap of a ball, its leaves in parallel are as stiff as the layer, E A / L.
TEST(LeafPaint, YoungsModulusMakesNeighbouringLeavesTogetherAsStiffAsTheLayer) {
  const double r = 0.05;
  Body body{"ball", MakeSphere(r, 5000), {}, {}};
  body.tree = BuildSphereTree(body.mesh, 2000);
  BodyDescription description;
  description.material.youngs_modulus = 2e6;
  description.material.thickness = 0.005;
  PaintLeaves(description, {}, body);
  std::size_t bearing = 0;
  std::size_t cap = 0;
  for (std::size_t i = 0; i < body.tree.leaves(); ++i) {
    const auto& begin = body.tree.leaf_triangle_begin;
    if (begin[i] == begin[i + 1]) continue;
    ++bearing;
    cap += Centre(body.tree, i).normalized().y() > 0.5;
  }
  const double k = body.materials[0].stiffness;
  EXPECT_NEAR(k * double(bearing), 2e6 * InspectMesh(body.mesh).area / 0.005, 1e-3);
  // A quarter of the ball's surface: 2 pi r^2 (1 - 1/2).
  EXPECT_NEAR(k * double(cap) / (2e6 * 3.14159265 * r * r / 0.005), 1.0, 0.05);
}

TEST(LeafPaint, HalvesOfABodyMayBeSoftAndHard) {
  Body body = BoxBody(Vec3(0.1, 0.1, 0.1), 1000);
  BodyDescription description;
  description.material.youngs_modulus = 1e6;
  description.material.thickness = 0.01;
  description.regions = {BoxRegion(Vec3(0, -1, -1), Vec3(1, 1, 1), 0)};
  description.regions[0].material.youngs_modulus = 1e9;
  description.regions[0].material.thickness = 0.01;
  PaintLeaves(description, {}, body);
  // Two halves of a cube: their leaves stand for equal areas, apart from chance.
  EXPECT_NEAR(body.materials[1].stiffness / body.materials[0].stiffness, 1000.0, 100.0);
}

TEST(LeafPaint, RegionThatPaintsNothingIsRefusedWithItsLine) {
  Body body = BoxBody(Vec3(0.1, 0.1, 0.1), 50);
  BodyDescription description;
  description.regions = {BoxRegion(Vec3(1, 1, 1), Vec3(2, 2, 2), 100)};
  EXPECT_THAT(ComplaintOf([&] { PaintLeaves(description, {}, body); }),
              HasSubstr("f.json:9: objects[0].regions[0]: covers no leaf of \"part\"; move or"));
}

/// Two boxes side by side in one OBJ.
std::string TwoParts() {
  const TriangleMesh box = MakeBox(Vec3(10, 10, 10));
  return "o crown\n" + test::ObjOf(test::Moved(box, Vec3(2, 0, 0))) + "o root\n" +
         test::ObjOf(test::Moved(box, Vec3(18, 0, 0)), 8);
}

std::string SceneWithGroup(const std::string& group) {
  return R"({"tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1}],
    "objects": [{"name": "tooth", "leaves": 200, "mesh": {"file": "parts.obj", "unit": "mm", "origin": "file"},
      "regions": [{"group": ")" +
         group + R"(", "material": {"stiffness_N_per_m": 500}}]}]})";
}

TEST(LeafPaint, PaintsTheNamedPartOfAMeshFile) {
  const std::string folder = test::FreshFolder();
  test::WriteFile(folder + "/parts.obj", TwoParts());
  LoadOptions options;
  options.use_cache = false;
  const Scene scene =
      LoadScene(test::WriteFile(folder + "/s.json", SceneWithGroup("root")), options);
  const Body& tooth = scene.objects[0];
  ASSERT_EQ(tooth.leaf_material.size(), 200u);
  for (std::size_t i = 0; i < 200; ++i) {
    const auto& begin = tooth.tree.leaf_triangle_begin;
    if (begin[i] == begin[i + 1]) continue;
    // The crown spans x from -3 to 7 mm, the root from 13 to 23.
    EXPECT_EQ(tooth.leaf_material[i], Centre(tooth.tree, i).x() > 0.01) << i;
  }
  EXPECT_TRUE(scene.features.compliance);
  EXPECT_THAT(ComplaintOf([&] {
                LoadScene(test::WriteFile(folder + "/t.json", SceneWithGroup("rot")), options);
              }),
              HasSubstr("objects[0].regions[0].group: the mesh has no part \"rot\"; did you mean "
                        "\"root\"? It has: \"crown\", \"root\"."));
}

/// Two parts in one mesh, each with its own stiffness.
struct Parts {
  Body body{"tooth", {}, {}, {}};
  std::vector<MeshGroup> groups;

  void Add(const std::string& name, const TriangleMesh& part, const Vec3& at) {
    const auto begin = static_cast<std::uint32_t>(body.mesh.triangles.size());
    body.mesh = test::Both(body.mesh, test::Moved(part, at));
    groups.push_back({name, begin, static_cast<std::uint32_t>(body.mesh.triangles.size())});
  }

  void PaintGum(std::size_t leaves) {
    body.tree = BuildSphereTree(body.mesh, leaves);
    BodyDescription description;
    description.regions = {{}};
    description.regions[0].kind = RegionDescription::Kind::kGroup;
    description.regions[0].group = "gum";
    description.regions[0].where = "f.json:9: objects[0].regions[0]";
    description.regions[0].material.youngs_modulus = 5e6;
    description.regions[0].material.thickness = 0.002;
    PaintLeaves(description, groups, body);
  }

  std::size_t Soft() const { return std::ranges::count(body.leaf_material, 1); }
};

TEST(LeafPaint, SheetInsideABoxMakesNoLeafSoft) {
  for (const double below_the_top : {0.0005, 0.001, 0.003, 0.005}) {
    Parts parts;
    parts.Add("crown", MakeBox(Vec3(0.01, 0.01, 0.01)), Vec3::Zero());
    parts.Add("gum", test::MakeSheet(0.0045, 1, [](double, double) { return 0.0; }),
              Vec3(0, 0.005 - below_the_top, 0));
    EXPECT_THAT(ComplaintOf([&] { parts.PaintGum(280); }),
                HasSubstr("f.json:9: objects[0].regions[0]: covers no leaf of \"tooth\"; the part "
                          "may lie entirely inside others"))
        << below_the_top;
    EXPECT_EQ(parts.Soft(), 0u);
  }
}

TEST(LeafPaint, PartThatSticksOutIsSoftWhereItDoes) {
  Parts parts;
  parts.Add("crown", MakeBox(Vec3(0.01, 0.01, 0.01)), Vec3::Zero());
  parts.Add("gum", MakeBox(Vec3(0.018, 0.004, 0.004)), Vec3(0.006, 0, 0));  // x from -3 to 15 mm
  parts.PaintGum(600);
  EXPECT_GT(parts.Soft(), 60u);
  for (std::size_t i = 0; i < parts.body.tree.leaves(); ++i) {
    const Vec3 c = Centre(parts.body.tree, i);
    const bool soft = parts.body.leaf_material[i] == 1;
    // In a corner between the parts, a leaf may touch both.
    if (soft) {
      EXPECT_GT(c.x(), 0.004) << c.transpose();
    }
    if (c.x() > 0.006 &&
        parts.body.tree.leaf_triangle_begin[i] != parts.body.tree.leaf_triangle_begin[i + 1]) {
      EXPECT_TRUE(soft) << c.transpose();
    }
  }
}

}  // namespace
}  // namespace palpate
