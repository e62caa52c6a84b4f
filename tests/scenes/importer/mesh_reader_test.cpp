// Mesh files as programs write them: each is read as the body it describes, or rightly refused.
#include "scenes/importer/mesh_reader.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/mesh/mesh_report.h"
#include "tests/scenes/support.h"
#include "tests/support/dirty_mesh.h"
#include "tests/support/refusals.h"
#include "tests/support/written_mesh.h"

namespace palpate {
namespace {

using test::AnyHand;
using test::Append;
using test::BinaryStlOf;
using test::ComplaintOf;
using test::Glb;
using test::GltfFields;
using test::Json;
using test::With;
using test::WrittenBox;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

void ExpectTheBox(const std::string& name, const std::string& text, double unit = 1.0) {
  SCOPED_TRACE(name + ":\n" + text.substr(0, 400));
  try {
    const MeshReport r = InspectMesh(ReadMeshText(name, text).mesh);
    EXPECT_EQ(r.triangles, 12u);
    EXPECT_EQ(r.vertices, 8u);
    EXPECT_TRUE(r.solid());
    EXPECT_NEAR(r.volume / std::pow(unit, 3), 1920.0, 1e-2);
    EXPECT_NEAR((r.box_min / unit - Vec3(1, 2, 3)).norm(), 0.0, 1e-5);
    EXPECT_NEAR((r.box_max / unit - Vec3(21, 14, 11)).norm(), 0.0, 1e-5);
  } catch (const Error& error) {
    ADD_FAILURE() << error.what();
  }
}

std::string Complaint(const std::string& name, const std::string& text) {
  return ComplaintOf([&] { ReadMeshText(name, text); });
}

// --- OBJ ---

// AnyLayout, below, tests blanks, line ends, signs, colours, continued lines, negative indices and
// the like; each format has here what AnyLayout does not write.

TEST(ObjReader, ReadsEveryLineAsItIsWritten) {
  const std::string plain = test::ObjOf(WrittenBox());
  ExpectTheBox("a.obj", plain);
  ExpectTheBox("comments.obj", "# C:\\meshes\\\n" + With(plain, "\n", " # here\n"));
  ExpectTheBox("normals.obj", "vn -nan(ind) 1.#QNAN inf\n" +
                                  With(plain, "f (.*) (.*) (.*)\n", "f $1//1 $2//1 $3//1\n"));
  ExpectTheBox("capitals.obj", With(With(plain, "v ", "V "), "f ", "F "));
}

TEST(ObjReader, KnowsObjectsAndTheGroupsInThem) {
  const ImportedMesh read = ReadMeshText("a.obj",
                                         "v 0 0 0\nv 1 0 0\nv 0 1 0\no jaw\ng left side\nf 1 2 "
                                         "3\ng right\nf 1 3 2\no tooth\nf 2 1 3\n");
  std::string groups;
  for (const MeshGroup& g : read.groups) {
    groups += g.name + " " + std::to_string(g.begin) + "-" + std::to_string(g.end) + ", ";
  }
  EXPECT_EQ(groups, "left side 0-1, jaw 0-2, tooth 2-3, right 1-3, ");
}

TEST(Polygons, AreCutWithinTheirOutlineWhereTheyAreNotConvex) {
  // An L whose first vertex is next to the inner one, upright in space.
  const TriangleMesh mesh =
      ReadMeshText("l.obj", "v 1 0 1\nv 1 0 2\nv 0 0 2\nv 0 0 0\nv 2 0 0\nv 2 0 1\nf 1 2 3 4 5 6\n")
          .mesh;
  const MeshReport r = InspectMesh(mesh);
  EXPECT_EQ(r.triangles, 4u);
  EXPECT_NEAR(r.area, 3.0, 1e-12);  // a fan would give 5
  EXPECT_TRUE(r.oriented());
  EXPECT_EQ(r.boundary_edges, 6u);
}

// --- STL ---

TEST(StlReader, ReadsTextWithAnyWordsInItsNames) {
  const std::string plain = test::TextStlOf(WrittenBox());
  ExpectTheBox("a.stl", plain);
  ExpectTheBox("words.stl", With(plain, "solid mesh", "solid L4 facet joint endsolid 3"));
  ExpectTheBox("no_name.stl", With(With(plain, "solid mesh", "solid "), "\n", "\r\n"));
  ExpectTheBox("end_facet.stl", With(With(plain, "endfacet", "End Facet"), "endloop", "END LOOP"));
  ExpectTheBox("padded.stl", plain + std::string(100, '\0') + "\x1a");
  for (const char* none : {"nan NaN -nan(ind)", "inf -inf 1.#QNAN", "", "1 2"}) {
    ExpectTheBox("normal.stl", With(plain, "normal 0 0 0", std::string("normal ") + none));
  }
}

TEST(StlReader, ReadsEverySolidAsAPart) {
  const std::string two =
      With(test::TextStlOf(WrittenBox()), "mesh", "a") +
      With(test::TextStlOf(test::Moved(WrittenBox(), Vec3(30, 0, 0))), "mesh", "b c");
  const ImportedMesh read = ReadMeshText("two.stl", two);
  EXPECT_EQ(InspectMesh(read.mesh).triangles, 24u);
  ASSERT_EQ(read.groups.size(), 2u);
  EXPECT_EQ(read.groups[1].name, "b c");
  EXPECT_EQ(read.groups[1].begin, 12u);
}

TEST(StlReader, TellsBinaryFromTextWhateverTheHeaderSays) {
  for (const char* header : {"solid box\n facet normal 0 0 1\n outer loop\n", "\xef\xbb\xbf"}) {
    ExpectTheBox("b.stl", BinaryStlOf(WrittenBox(), header));
  }
}

TEST(StlReader, PassesOverWhatStandsBehindButNoFacet) {
  const std::string whole = BinaryStlOf(WrittenBox());
  ExpectTheBox("zeros.stl", whole + std::string(428, '\0'));
  ExpectTheBox("words.stl",
               whole + "made by a scanner that signs its files, with sixty bytes or more");
  std::string fewer = whole;
  fewer[80] = 11;
  EXPECT_THAT(Complaint("fewer.stl", fewer),
              HasSubstr("fewer.stl: it declares 11 facets, and at least 12 are present"));
  fewer[80] = 13;
  EXPECT_THAT(Complaint("more.stl", fewer), HasSubstr("declares 13 facets, and 12 are present"));
}

// --- PLY ---

TEST(PlyReader, PassesOverNumbersThatAreNone) {
  const std::string plain = test::PlyOf(WrittenBox(), false);
  ExpectTheBox("a.ply", With(With(plain, "uchar red", "float red"), "\n7 ", "\n-nan(ind) "));
}

TEST(PlyReader, ReadsStripsOfTriangles) {
  const std::vector<int> strips{0, 1, 2, 3, -1, 4, 6, 5, 7, -1, 0, 4, 1, 5, -1,
                                2, 3, 6, 7, -1, 0, 2, 4, 6, -1, 1, 5, 3, 7, -1};
  for (const bool binary : {false, true}) {
    std::string text =
        std::string("ply\nformat ") + (binary ? "binary_little_endian" : "ascii") +
        " 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
        "element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    const auto put = [&](auto value) {
      binary ? Append(text, value) : void(text += std::to_string(value) + "\n");
    };
    for (const float x : {1.0f, 21.0f}) {
      for (const float y : {2.0f, 14.0f}) {
        for (const float z : {3.0f, 11.0f}) {
          for (const float number : {x, y, z}) put(number);
        }
      }
    }
    put(static_cast<std::int32_t>(strips.size()));
    for (const int v : strips) put(v);
    ExpectTheBox("strips.ply", text);
  }
}

// --- glTF ---

TEST(GltfReader, ReadsWhatStandsInItsScene) {
  ExpectTheBox("a.glb", Glb(Json({})), 1e-3);
  ExpectTheBox("no_default.glb", Glb(Json({.scene = R"("scenes":[{"nodes":[0]}])"})), 1e-3);
  ExpectTheBox("no_scene.glb", Glb(Json({.scene = "", .nodes = R"({"children":[1]},{"mesh":0})"})),
               1e-3);
  ExpectTheBox("trailing.glb", Glb(Json({})) + "\nand more", 1e-3);
  ExpectTheBox(
      "matrix.glb",
      Glb(Json({.nodes = R"({"mesh":0,"matrix":[1000,0,0,0,0,1000,0,0,0,0,1000,0,0,0,0,1]})"})));
  ExpectTheBox("hidden.glb",
               Glb(Json({.scene = R"("scenes":[{"nodes":[0,1]}])",
                         .nodes = R"({"mesh":0},{"mesh":0,"scale":[0,0,0]})"})),
               1e-3);
}

TEST(GltfReader, ReadsABufferOfAnySizeInTheText) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::string glb = Glb("", std::string(30'000, 'x'));  // no JSON: the buffer starts at 28
  std::string base64;
  for (std::size_t at = 28; at + 3 <= glb.size(); at += 3) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(glb[at + i]); };
    const unsigned bits = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (const int shift : {18, 12, 6, 0}) base64 += kDigits[bits >> shift & 63];
  }
  ExpectTheBox(
      "a.gltf",
      Json({.buffers = R"({"byteLength":168,"uri":"data:application/octet-stream;base64,)" +
                       base64 + "\"}"}),
      1e-3);
}

TEST(GltfReader, TurnsWhatIsMirroredAndReadsWhatStandsThereTwice) {
  const MeshReport r = InspectMesh(
      ReadMeshText("a.glb", Glb(Json({.scene = R"("scenes":[{"nodes":[0,2]}])",
                                      .nodes = R"({"scale":[-1,1,1],"children":[1]},{"mesh":0},
{"mesh":0,"translation":[0.05,0,0]})"})))
          .mesh);
  EXPECT_EQ(r.triangles, 24u);
  EXPECT_TRUE(r.solid());
  EXPECT_NEAR(r.volume, 2 * 1920e-9, 1e-12);  // a box inside out would subtract
  EXPECT_NEAR((r.box_min - Vec3(-0.021, 0.002, 0.003)).norm(), 0.0, 1e-8);
  EXPECT_NEAR((r.box_max - Vec3(0.071, 0.014, 0.011)).norm(), 0.0, 1e-8);
}

/// As gltfpack writes: integers, entries padded to whole words, and a node that scales them back.
template <class T>
std::string Quantised(int type, double one) {
  std::string more;
  const Vec3 centre(11, 8, 7);
  for (const Vec3& v : WrittenBox().vertices) {
    for (const double x : v - centre) Append(more, static_cast<T>(std::round(x * one / 10.0)));
    Append(more, T{99});
  }
  const std::size_t positions = more.size();
  for (const auto& triangle : WrittenBox().triangles) {
    for (const std::uint32_t v : triangle) Append(more, static_cast<std::uint16_t>(v));
  }
  const bool normalized = one == std::numeric_limits<T>::max();
  const double scale = normalized ? 0.01 : 0.01 / one;
  std::ostringstream node;
  node << R"({"mesh":0,"translation":[0.011,0.008,0.007],"scale":[)" << scale << "," << scale << ","
       << scale << "]}";
  return Glb(Json({.nodes = node.str(),
                   .position = R"("bufferView":0,"count":8,"type":"VEC3","componentType":)" +
                               std::to_string(type) + (normalized ? R"(,"normalized":true)" : ""),
                   .more = R"(,"extensionsRequired":["KHR_mesh_quantization"])",
                   .views = R"({"buffer":0,"byteStride":)" + std::to_string(4 * sizeof(T)) +
                            R"(,"byteLength":)" + std::to_string(positions) +
                            R"(},{"buffer":0,"byteOffset":)" + std::to_string(positions) +
                            R"(,"byteLength":72})"}),
             more, false);
}

TEST(GltfReader, ReadsQuantisedCoordinates) {
  for (const auto& [text, off] : {std::pair{Quantised<std::int16_t>(5122, 32767), 1e-6},
                                  {Quantised<std::int16_t>(5122, 1000), 1e-6},
                                  {Quantised<std::int8_t>(5120, 127), 5e-5},
                                  {Quantised<std::int8_t>(5120, 100), 1e-6}}) {
    const MeshReport r = InspectMesh(ReadMeshText("q.glb", text).mesh);
    EXPECT_TRUE(r.solid());
    EXPECT_NEAR((r.box_min - Vec3(0.001, 0.002, 0.003)).norm(), 0.0, off);
    EXPECT_NEAR((r.box_max - Vec3(0.021, 0.014, 0.011)).norm(), 0.0, off);
  }
}

TEST(GltfReader, ReadsStripsAndFans) {
  for (const auto& [mode, corners, area] :
       {std::tuple{5, std::vector<std::uint16_t>{0, 1, 2, 3}, 4.0}, {6, {0, 1, 3, 2}, 4.0}}) {
    std::string more;
    for (const float x : {0.f, 0.f, 0.f, 2.f, 0.f, 0.f, 0.f, 2.f, 0.f, 2.f, 2.f, 0.f})
      Append(more, x);
    for (const std::uint16_t v : corners) Append(more, v);
    GltfFields f{
        .views = R"({"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":8})",
        .primitive = R"(,"mode":)" + std::to_string(mode)};
    f.position = R"("bufferView":0,"componentType":5126,"count":4,"type":"VEC3")";
    const MeshReport r = InspectMesh(
        ReadMeshText("m.glb", Glb(With(Json(f), "\"count\":36", "\"count\":4"), more, false)).mesh);
    EXPECT_EQ(r.triangles, 2u);
    EXPECT_TRUE(r.oriented());
    EXPECT_NEAR(r.area, area, 1e-12);
  }
}

TEST(GltfReader, RefusesByItsNameWhatItDoesNotRead) {
  const std::string required = R"(,"extensionsRequired":["EXT_meshopt_compression"])";
  // With a plain copy the data are read; without one there are none.
  ExpectTheBox("m.glb",
               Glb(Json({.more = required, .buffers = R"({"byteLength":168},{"byteLength":96,
"extensions":{"EXT_meshopt_compression":{"fallback":true}}})"})),
               1e-3);
  EXPECT_THAT(Complaint("m.glb", Glb(Json({.more = required,
                                           .views = R"({"buffer":1,"byteLength":96,
"extensions":{"EXT_meshopt_compression":{"buffer":0}}},{"buffer":0,"byteOffset":96,"byteLength":72})",
                                           .buffers = R"({"byteLength":168},{"byteLength":96})"}))),
              AllOf(StartsWith("m.glb:"), HasSubstr("\"EXT_meshopt_compression\""),
                    HasSubstr("uncompressed")));
  EXPECT_THAT(
      Complaint("d.glb",
                Glb(Json({.more = R"(,"extensionsRequired":["KHR_draco_mesh_compression"])"}))),
      AllOf(HasSubstr("\"KHR_draco_mesh_compression\""), HasSubstr("uncompressed")));
  EXPECT_THAT(
      Complaint("d.glb",
                Glb(Json({.position = R"("componentType":5126,"count":8,"type":"VEC3")",
                          .primitive = R"(,"extensions":{"KHR_draco_mesh_compression":{}})"}))),
      HasSubstr("\"KHR_draco_mesh_compression\""));
  EXPECT_THAT(Complaint("s.glb", Glb(Json({.nodes = R"({"mesh":0,"skin":0})"}))),
              HasSubstr("bones"));
  EXPECT_THAT(Complaint("w.glb", Glb(Json({.nodes = R"({"mesh":0,"weights":[0,0.5]})"}))),
              HasSubstr("shape key"));
  EXPECT_THAT(Complaint("i.glb", Glb(Json({.nodes = R"({"mesh":0,
"extensions":{"EXT_mesh_gpu_instancing":{}}})"}))),
              HasSubstr("EXT_mesh_gpu_instancing"));
  EXPECT_THAT(Complaint("t.glb", Glb(Json({.nodes = R"({"children":[0],"mesh":0})"}))),
              HasSubstr("listed twice"));
  ExpectTheBox("looks.glb", Glb(Json({.more = R"(,"extensionsRequired":["KHR_materials_unlit",
"KHR_texture_transform"])"})),
               1e-3);
}

TEST(GltfReader, RefusesWhatReachesBeyondItsBuffer) {
  EXPECT_THAT(
      Complaint("a.glb", Glb(Json({.position = R"("bufferView":0,"componentType":5126,"count":9,
"type":"VEC3")"}))),
      HasSubstr("beyond the end of its view"));
  EXPECT_THAT(Complaint("a.glb", Glb(Json({.views = R"({"buffer":0,"byteLength":96},
{"buffer":0,"byteOffset":97,"byteLength":72})"}))),
              HasSubstr("beyond the end of its buffer"));
  EXPECT_THAT(Complaint("a.glb", Glb(Json({})).substr(0, 500)), HasSubstr("declares"));
}

// --- any file ---

TEST(MeshReader, SaysWhatIsWrongAndWhere) {
  test::ExpectRefusals("tests/scenes/importer/mesh_reader.refusals",
                       [](const auto& inputs) { return Complaint(inputs.at(0), inputs.at(1)); });
  EXPECT_THAT(Complaint("a.obj", std::string("\xff\xfe") + "v"), HasSubstr("UTF-16"));
}

/// Vertex positions in the order of the file.
std::string CornersOf(const TriangleMesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int c = 0; c < 3; ++c) text << test::Corner(mesh, t, c).transpose() << "; ";
    text << "\n";
  }
  return text.str();
}

class AnyLayout : public testing::TestWithParam<
                      std::pair<const char*, std::string (*)(const TriangleMesh&, AnyHand&)>> {};

TEST_P(AnyLayout, IsReadAsTheSameTriangles) {
  const auto [format, write] = GetParam();
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    AnyHand hand(seed);
    const TriangleMesh mesh = hand.Mesh();
    const std::string text = write(mesh, hand);
    try {
      ASSERT_EQ(CornersOf(ReadMeshText(std::string("any.") + format, text).mesh), CornersOf(mesh))
          << "seed " << seed << ":\n"
          << text;
    } catch (const Error& error) {
      FAIL() << "seed " << seed << ": " << error.what() << ":\n" << text;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(MeshReader, AnyLayout,
                         testing::Values(std::pair{"obj", &test::AnyObj},
                                         std::pair{"stl", &test::AnyStl},
                                         std::pair{"ply", &test::AnyPly},
                                         std::pair{"glb", &test::AnyGlb}),
                         [](const auto& given) { return std::string(given.param.first); });

}  // namespace
}  // namespace palpate
