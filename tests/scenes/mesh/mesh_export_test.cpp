#include "scenes/mesh/mesh_export.h"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/importer/mesh_reader.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/units.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;

const TriangleMesh kEgg = MakeEllipsoid(Vec3(0.01, 0.02, 0.03), 320);

TEST(MeshExport, IsReadBackAsTheSameMeshFromEachFormatAndUnit) {
  for (const char* const name : {"egg.stl", "egg.obj", "EGG.PLY"}) {
    for (const std::string_view unit : kUnits) {
      SCOPED_TRACE(std::string(name) + " in " + std::string(unit));
      const double metres = MetresPerUnit(unit);
      const TriangleMesh read =
          ReadMeshText(name, ExportMesh(kEgg, name, {.metres_per_unit = metres, .comment = "egg"}))
              .mesh;
      ASSERT_EQ(read.triangles.size(), kEgg.triangles.size());
      EXPECT_TRUE(InspectMesh(read).solid());
      for (std::size_t t = 0; t < read.triangles.size(); ++t) {
        for (std::size_t c = 0; c < 3; ++c) {
          const Vec3& wrote = kEgg.vertices[kEgg.triangles[t][c]];
          const Vec3 got = metres * read.vertices[read.triangles[t][c]];
          EXPECT_LT((got - wrote).cwiseAbs().maxCoeff(), 0x1p-24 * 0.04);
        }
      }
    }
  }
}

TEST(MeshExport, ColoursFacesAndTheirCornersInAPly) {
  std::vector<std::uint32_t> colours(kEgg.triangles.size(), 0x102030);
  colours.back() = 0xff8001;
  const std::string ply = ExportMesh(kEgg, "egg.ply", {.comment = "egg", .colours = colours});
  EXPECT_EQ(ply.substr(ply.size() - 3), "\xff\x80\x01");
  EXPECT_EQ(ply.substr(ply.size() - 16 - 3, 3), "\x10\x20\x30");
  const std::size_t first_vertex = ply.find("end_header\n") + 11;
  constexpr std::size_t kVertex = 3 * sizeof(double) + 3;
  for (const std::uint32_t corner : kEgg.triangles.back()) {
    EXPECT_EQ(ply.substr(first_vertex + kVertex * (corner + 1) - 3, 3), "\xff\x80\x01");
  }
  EXPECT_EQ(ReadMeshText("egg.ply", ply).mesh.triangles.size(), kEgg.triangles.size());
}

TEST(MeshExport, RefusesWhatCouldNotBeReadBack) {
  const auto complaint = [](const TriangleMesh& mesh, const char* file) {
    return ComplaintOf([&] { ExportMesh(mesh, file, {}); });
  };
  EXPECT_THAT(complaint(kEgg, "egg.glb"), HasSubstr(".ply"));
  EXPECT_THAT(complaint(kEgg, "stl"), HasSubstr(".stl"));
  TriangleMesh broken = kEgg;
  broken.vertices[7].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(complaint(broken, "egg.stl"), HasSubstr("vertex 7"));
  broken = kEgg;
  broken.triangles[5][1] = 9999;
  EXPECT_THAT(complaint(broken, "egg.obj"), HasSubstr("triangle 5"));
}

}  // namespace
}  // namespace palpate
