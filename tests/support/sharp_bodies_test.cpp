#include "tests/support/sharp_bodies.h"

#include <string>

#include <gtest/gtest.h>

#include "scenes/mesh/mesh_report.h"

namespace palpate::test {
namespace {

TEST(SharpBodies, ExtrudeAnOutlineWithHollowCorners) {
  // A U of 3 x 2 with a slot of 1 x 1.
  const Vec3 outline[] = {{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {2, 2, 0},
                          {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  const TriangleMesh mesh = Extruded(outline, 0.5);
  EXPECT_TRUE(InspectMesh(mesh).solid());
  EXPECT_NEAR(InspectMesh(mesh).volume, 2.5, 1e-12);
  EXPECT_EQ(mesh.triangles.size(), 2u * 6u + 16u);
}

TEST(SharpBodies, AreClosedAndFaceOutwardsForEverySeed) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    for (const TriangleMesh& mesh :
         {MakeComb(seed), MakeGear(seed), MakeNotchedPlate(seed), MakeDie(seed)}) {
      const MeshReport report = InspectMesh(mesh);
      ASSERT_TRUE(report.solid()) << "seed " << seed;
      const double box = (report.box_max - report.box_min).prod(), volume = report.volume;
      ASSERT_GT(volume, 0.3 * box) << "seed " << seed;
      ASSERT_LT(volume, box) << "seed " << seed;
      ASSERT_LT((report.box_max + report.box_min).norm(), 1e-12) << "seed " << seed;
    }
  }
}

TEST(SharpBodies, MakeScenesByNameAndSeed) {
  for (const std::string_view name : kSharpScenes) {
    const std::optional<Scene> first = MakeSharpScene(name);
    ASSERT_TRUE(first) << name;
    EXPECT_NE(first->tools[0].mesh.vertices, first->objects[0].mesh.vertices) << name;
  }
  const auto tool = [](const char* name) { return MakeSharpScene(name)->tools[0].mesh.vertices; };
  EXPECT_EQ(tool("sharp-dice"), tool("sharp-dice:1"));
  EXPECT_NE(tool("sharp-dice"), tool("sharp-dice:2"));
  for (const char* name : {"bunny-bunny", "sharp", "sharp-gears:", "sharp-gears:2b", ""}) {
    EXPECT_FALSE(MakeSharpScene(name)) << name;
  }
}

}  // namespace
}  // namespace palpate::test
