#include "tests/support/plain_tools.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "scenes/mesh/mesh_report.h"

namespace palpate::test {
namespace {

TEST(PlainTools, StandLevelWithTheirCentroidAboveTheirFoot) {
  for (const std::string_view name : kPlainTools) {
    if (name == "ball") continue;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      SCOPED_TRACE(std::string(name) + ", seed " + std::to_string(seed));
      const Body tool = MakePlainTool(name, seed);
      double lowest = INFINITY;
      for (const Vec3& v : tool.mesh.vertices) lowest = std::min(lowest, v.y());
      // In each direction some corner of the foot lies beyond the centroid.
      for (int i = 0; i < 64; ++i) {
        const Vec3 along(std::cos(0.1 * i), 0.0, std::sin(0.1 * i));
        double beyond = -INFINITY;
        for (const Vec3& v : tool.mesh.vertices) {
          if (v.y() == lowest) beyond = std::max(beyond, along.dot(v - tool.tree.centroid));
        }
        ASSERT_GT(beyond, 5e-5) << "along " << along.transpose();
      }
      EXPECT_GT(tool.tree.centroid.y(), lowest + 5e-4);
    }
  }
}

TEST(PlainTools, AreClosedAndOfAHandsSize) {
  for (const std::string_view name : kPlainTools) {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      SCOPED_TRACE(std::string(name) + ", seed " + std::to_string(seed));
      const MeshReport report = InspectMesh(MakePlainTool(name, seed).mesh);
      EXPECT_TRUE(report.solid());
      EXPECT_GT(report.volume, 0.0);
      EXPECT_EQ(report.components, name == "pins" ? 4u : 1u);
      EXPECT_LT((report.box_max - report.box_min).maxCoeff(), 0.021);
      EXPECT_GT((report.box_max - report.box_min).maxCoeff(), 0.0019);
    }
  }
}

}  // namespace
}  // namespace palpate::test
