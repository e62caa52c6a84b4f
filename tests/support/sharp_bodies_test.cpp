#include "tests/support/sharp_bodies.h"

#include <map>
#include <string>
#include <utility>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

/// Each edge must be used once in each direction.
bool IsClosed(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    if (count != 1 || edges.count({edge.second, edge.first}) == 0) return false;
  }
  return !edges.empty();
}

double VolumeOf(const TriangleMesh& mesh) {
  double six = 0.0;
  for (const auto& t : mesh.triangles) {
    six += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  }
  return six / 6.0;
}

TEST(SharpBodies, ExtrudeAnOutlineWithHollowCorners) {
  // A U of 3 x 2 with a slot of 1 x 1.
  const Vec3 outline[] = {{0, 0, 0}, {3, 0, 0}, {3, 2, 0}, {2, 2, 0},
                          {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  const TriangleMesh mesh = Extruded(outline, 0.5);
  EXPECT_TRUE(IsClosed(mesh));
  EXPECT_NEAR(VolumeOf(mesh), 2.5, 1e-12);
  EXPECT_EQ(mesh.triangles.size(), 2u * 6u + 16u);
}

TEST(SharpBodies, AreClosedAndFaceOutwardsForEverySeed) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    for (const TriangleMesh& mesh :
         {MakeComb(seed), MakeGear(seed), MakeNotchedPlate(seed), MakeDie(seed)}) {
      ASSERT_TRUE(IsClosed(mesh)) << "seed " << seed;
      Vec3 low = Vec3::Constant(1.0), high = -low;
      for (const Vec3& v : mesh.vertices) {
        low = low.cwiseMin(v);
        high = high.cwiseMax(v);
      }
      const double box = (high - low).prod(), volume = VolumeOf(mesh);
      ASSERT_GT(volume, 0.3 * box) << "seed " << seed;
      ASSERT_LT(volume, box) << "seed " << seed;
      ASSERT_LT((high + low).norm(), 1e-12) << "seed " << seed;
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
