#include "scenes/mesh/mesh_import.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "scenes/mesh/mesh_report.h"
#include "tests/scenes/support.h"
#include "tests/support/dirty_mesh.h"
#include "tests/support/exported_box.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using test::ExportBox;
using test::FreshFolder;
using test::WriteFile;
using testing::HasSubstr;

void ExpectTheBox(const TriangleMesh& mesh) {
  const MeshReport r = InspectMesh(mesh);
  EXPECT_EQ(r.triangles, 12u);
  EXPECT_EQ(r.vertices, 8u);  // welded, however the format splits them
  EXPECT_TRUE(r.solid());
  EXPECT_NEAR(r.volume, 6.0, 1e-6);
  Vec3 size = r.box_max - r.box_min;
  std::sort(size.begin(), size.end());  // assimp swaps y and z when it writes 3DS
  EXPECT_NEAR((size - Vec3(1, 2, 3)).norm(), 0.0, 1e-6);
}

class EveryFormat : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(EveryFormat, GivesTheSameBox) {
  const auto [format, name] = GetParam();
  ExpectTheBox(ImportMesh(ExportBox(format, FreshFolder().append("/").append(name))));
}

INSTANTIATE_TEST_SUITE_P(MeshImport, EveryFormat,
                         testing::Values(std::pair{"obj", "box.obj"}, std::pair{"stl", "box.stl"},
                                         std::pair{"stlb", "binary.STL"},
                                         std::pair{"ply", "box.ply"}, std::pair{"plyb", "b.ply"},
                                         std::pair{"3ds", "box.3ds"},
                                         std::pair{"gltf2", "box.gltf"},
                                         std::pair{"glb2", "box.glb"}));

std::string Gzip(const std::string& file) {
  const std::string text = ReadWholeFile(file);
  const std::string packed = file + ".gz";
  gzFile gz = gzopen(packed.c_str(), "wb");
  gzwrite(gz, text.data(), text.size());
  gzclose(gz);
  return packed;
}

TEST(MeshImport, UnpacksGzippedFiles) {
  ExpectTheBox(ImportMesh(Gzip(ExportBox("ply", FreshFolder() + "/box.ply"))));
}

TEST(MeshImport, SaysWhyAFileIsNoMesh) {
  const std::string folder = FreshFolder();
  const auto complaint = [](const std::string& file) {
    return ComplaintOf([&] { ImportMesh(file); });
  };
  EXPECT_THAT(complaint(folder + "/none.obj"), HasSubstr("none.obj: there is no such file"));
  EXPECT_THAT(complaint(folder), HasSubstr("its name has no extension"));
  EXPECT_THAT(complaint(WriteFile(folder + "/a.step", "x")),
              HasSubstr("the format \"step\" is not known; convert it to OBJ"));
  EXPECT_THAT(complaint(WriteFile(folder + "/a.ply", "not a ply")),
              HasSubstr("a.ply: its PLY header"));
  EXPECT_THAT(complaint(WriteFile(folder + "/a.glb", "not a glb")),
              HasSubstr("a.glb: it is not a .glb"));
  EXPECT_THAT(complaint(WriteFile(folder + "/a.gltf", "{}")),
              HasSubstr("a.gltf:1: asset is missing"));
  EXPECT_THAT(complaint(WriteFile(folder + "/empty.stl", "")), HasSubstr("empty.stl: "));
}

TEST(MeshImport, RefusesAGzippedFileThatIsCutShort) {
  const std::string packed = Gzip(ExportBox("ply", FreshFolder() + "/box.ply"));
  std::filesystem::resize_file(packed, std::filesystem::file_size(packed) / 2);
  EXPECT_THAT(ComplaintOf([&] { ImportMesh(packed); }), HasSubstr("is damaged ("));
}

TEST(MeshImport, LeavesNonFiniteNumbersForTheReportToRefuse) {
  const std::string file = ExportBox("stlb", FreshFolder() + "/box.stl");
  std::string bytes = ReadWholeFile(file);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bytes.data() + 84 + 12, &nan, sizeof nan);  // first corner of the first triangle
  WriteFile(file, bytes);
  EXPECT_THAT(ComplaintOf([&] {
                const MeshReport r = InspectMesh(ImportMesh(file));
                if (!r.refusal.empty()) throw Error(r.refusal);
              }),
              testing::Not(HasSubstr("no complaint")));
}

/// The box of 1 x 2 x 3 at about (1e6, -2e6, 3e6), on a grid finer than a float's spacing there.
const Vec3 kFar(1e6 + 0.0625, -2e6 - 0.4375, 3e6 + 0.3125);

void ExpectTheBoxFarOff(const std::string& file) {
  const MeshReport r = InspectMesh(ImportMesh(file));
  EXPECT_EQ(r.vertices, 8u);
  EXPECT_TRUE(r.solid());
  EXPECT_NEAR(r.volume, 6.0, 1e-6);
  EXPECT_NEAR((0.5 * (r.box_min + r.box_max) - kFar).norm(), 0.0, 1e-6);
}

TEST(MeshImport, ReadsInDoublePrecisionFarFromTheOrigin) {
  const std::string folder = FreshFolder();
  const TriangleMesh box = test::Moved(MakeBox(Vec3(1, 2, 3)), kFar);
  ExpectTheBoxFarOff(WriteFile(folder + "/far.obj", "o box\n" + test::ObjOf(box)));
  ExpectTheBoxFarOff(WriteFile(folder + "/far.stl", test::TextStlOf(box)));
  ExpectTheBoxFarOff(WriteFile(folder + "/text.ply", test::PlyOf(box, false)));
  ExpectTheBoxFarOff(WriteFile(folder + "/double.ply", test::PlyOf(box, true)));
}

TEST(MeshImport, RefusesAMeshThatItsFileHasCollapsed) {
  // A binary STL stores single precision, whose spacing is a quarter at 3 million.
  const std::string file = ExportBox("stlb", FreshFolder() + "/far.stl");
  std::string bytes = ReadWholeFile(file);
  for (std::size_t facet = 84; facet < bytes.size(); facet += 50) {
    for (std::size_t at = facet + 12; at < facet + 48; at += 4) {
      float value = 0;
      std::memcpy(&value, &bytes[at], 4);
      value += 3e6f;
      std::memcpy(&bytes[at], &value, 4);
    }
  }
  EXPECT_THAT(ComplaintOf([&] { ImportMesh(WriteFile(file, bytes)); }),
              HasSubstr("far.stl: is 3 across and lies 3e+06 from its origin"));
}

TEST(PlaceMesh, ScalesByUnitOrLongestSideAndMovesTheOrigin) {
  const auto placed = [](const MeshPlacement& placement) {
    TriangleMesh box = MakeBox(Vec3(10, 20, 40));
    for (Vec3& v : box.vertices) v += Vec3(5, 10, 20);
    PlaceMesh(placement, box);
    return InspectMesh(box);
  };
  MeshPlacement placement;
  placement.metres_per_unit = 0.001;
  placement.origin = MeshPlacement::Origin::kFile;
  EXPECT_NEAR((placed(placement).box_max - Vec3(0.01, 0.02, 0.04)).norm(), 0.0, 1e-15);
  EXPECT_NEAR(placed(placement).box_min.norm(), 0.0, 1e-15);
  placement.origin = MeshPlacement::Origin::kBoxCentre;
  EXPECT_NEAR((placed(placement).box_max - Vec3(0.005, 0.01, 0.02)).norm(), 0.0, 1e-15);
  placement.longest_side = 0.15;
  EXPECT_NEAR((placed(placement).box_max - Vec3(0.01875, 0.0375, 0.075)).norm(), 0.0, 1e-15);
}

TEST(PlaceMesh, CanPutTheOriginAtTheSolidsCentroid) {
  TriangleMesh tetrahedron;  // centroid at a quarter, centre of the bounding box at a half
  tetrahedron.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  tetrahedron.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  MeshPlacement placement;
  placement.origin = MeshPlacement::Origin::kCentroid;
  PlaceMesh(placement, tetrahedron);
  EXPECT_NEAR((tetrahedron.vertices[0] + Vec3::Constant(0.25)).norm(), 0.0, 1e-15);
}

}  // namespace
}  // namespace palpate
