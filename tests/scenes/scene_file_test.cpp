#include "scenes/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;
using testing::StartsWith;

constexpr char kGood[] = R"({
  "tools": [
    {"name": "probe", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1,
     "start": {"position_mm": [0, 80, 0]}}
  ],
  "objects": [
    {"name": "part", "mesh": {"file": "part.stl", "unit": "mm"}, "leaves": 100}
  ]
})";

/// The good scene with one text put in another's place.
std::string With(const std::string& old_text, const std::string& new_text) {
  std::string text = kGood;
  const std::size_t at = text.find(old_text);
  if (at == std::string::npos) throw Error("the test's text is not there: " + old_text);
  return text.replace(at, old_text.size(), new_text);
}

TEST(SceneFile, ReadsAScene) {
  const SceneDescription scene = ParseScene(kGood, "folder/demo.json");
  EXPECT_EQ(scene.name, "demo");
  ASSERT_EQ(scene.tools.size(), 1u);
  EXPECT_EQ(scene.tools[0].mesh.kind, MeshSource::Kind::kSphere);
  EXPECT_EQ(scene.tools[0].mesh.size.x(), 0.005);
  EXPECT_EQ(scene.tools[0].leaves, 1u);
  EXPECT_NEAR(scene.tools[0].X_WB.p.y(), 0.08, 1e-15);
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].mesh.what, "folder/part.stl");
  EXPECT_EQ(scene.objects[0].mesh.placement.metres_per_unit, 0.001);
  EXPECT_EQ(scene.objects[0].mesh.placement.origin, MeshPlacement::Origin::kBoxCentre);
  EXPECT_EQ(scene.coupling.stiffness, 1000.0);
  EXPECT_EQ(scene.coupling.torsional_stiffness, 1.0);
}

TEST(SceneFile, ReadsEveryKindOfMeshAndCoupling) {
  const SceneDescription scene = ParseScene(R"({
    "name": "all", "description": "d",
    "coupling": {"stiffness_N_per_m": 500, "torsional_stiffness_Nm_per_rad": 0.5},
    "tools": [{"name": "a", "leaves": 8, "mesh": {"shape": "box", "size_m": [1, 2, 3]}}],
    "objects": [
      {"name": "b", "leaves": 8, "mesh": {"shape": "ellipsoid", "semi_axes_m": [1, 2, 3],
                                          "triangles": 99}},
      {"name": "c", "leaves": 8, "mesh": {"model": "bunny", "longest_side_m": 0.15,
                                          "origin": "centroid"},
       "pose": {"rotation_deg": {"axis": [0, 0, 1], "angle": 180}}},
      {"name": "d", "leaves": 8, "mesh": {"file": "/x.ply", "unit": "inch", "origin": "file"}}]
  })",
                                            "f.json");
  EXPECT_EQ(scene.name, "all");
  EXPECT_EQ(scene.coupling.stiffness, 500.0);
  EXPECT_EQ(scene.coupling.torsional_stiffness, 0.5);
  EXPECT_EQ(scene.tools[0].mesh.size, Vec3(1, 2, 3));
  EXPECT_EQ(scene.objects[0].mesh.triangles, 99u);
  EXPECT_EQ(scene.objects[1].mesh.what, "bunny");
  EXPECT_EQ(scene.objects[1].mesh.placement.longest_side, 0.15);
  EXPECT_EQ(scene.objects[1].mesh.placement.origin, MeshPlacement::Origin::kCentroid);
  EXPECT_NEAR(std::abs(scene.objects[1].X_WB.q.z()), 1.0, 1e-12);
  EXPECT_EQ(scene.objects[2].mesh.what, "/x.ply");
  EXPECT_EQ(scene.objects[2].mesh.placement.metres_per_unit, 0.0254);
}

struct Bad {
  const char* name;
  const char* old_text;
  const char* new_text;
  const char* complaint;
};

class BadScene : public testing::TestWithParam<Bad> {};

TEST_P(BadScene, IsRefusedWithLineFieldAndRemedy) {
  const Bad& bad = GetParam();
  const std::string text = With(bad.old_text, bad.new_text);
  const std::string complaint = ComplaintOf([&] { ParseScene(text, "f.json"); });
  EXPECT_THAT(complaint, StartsWith("f.json:"));
  EXPECT_THAT(complaint, HasSubstr(bad.complaint));
}

INSTANTIATE_TEST_SUITE_P(
    SceneFile, BadScene,
    testing::Values(
        Bad{"NoLeaves", "\"leaves\": 1,", "", "f.json:3: tools[0]: leaves is missing; add it"},
        Bad{"ZeroLeaves", "\"leaves\": 1,", "\"leaves\": 0,",
            "f.json:3: tools[0].leaves: 0 is not allowed; give a number from 1 to"},
        Bad{"HalfALeaf", "\"leaves\": 1,", "\"leaves\": 1.5,",
            "tools[0].leaves: 1.5 is not a whole number"},
        Bad{"TooManyLeaves", "\"leaves\": 100", "\"leaves\": 1e9",
            "objects[0].leaves: 1e+09 is not"},
        Bad{"LeavesInWords", "\"leaves\": 100", "\"leaves\": \"many\"",
            "f.json:7: objects[0].leaves: is a string; give a number"},
        Bad{"UnknownField", "\"leaves\": 100", "\"leafs\": 100",
            "f.json:7: objects[0].leafs: there is no such field; did you mean \"leaves\"?"},
        Bad{"UnknownTopField", "\"objects\"", "\"object\"", "did you mean \"objects\"?"},
        Bad{"PoseForATool", "\"start\"", "\"pose\"", "tools[0].pose: there is no such field"},
        Bad{"NoTools", "\"tools\": [\n    {\"name\"",
            "\"tools\": [], \"objects\": [\n    {\"name\"", "stands twice"},
        Bad{"NoShape", "\"sphere\"", "\"cone\"",
            "tools[0].mesh.shape: \"cone\" is not known; give one of box, ellipsoid, sphere"},
        Bad{"NegativeRadius", "0.005", "-0.005", "tools[0].mesh.radius_m: -0.005"},
        Bad{"ForgottenUnit", "0.005", "5000", "tools[0].mesh.radius_m: is more than 1000 m"},
        Bad{"NoScale", ", \"unit\": \"mm\"", "",
            "objects[0].mesh: has no scale; add \"unit\" (m, cm, mm or inch) or"},
        Bad{"TwoScales", "\"unit\": \"mm\"", "\"unit\": \"mm\", \"longest_side_m\": 1",
            "objects[0].mesh.longest_side_m: the scale is given twice"},
        Bad{"UnknownUnit", "\"mm\"", "\"feet\"",
            "\"feet\" is not known; give one of m, cm, mm, inch"},
        Bad{"NoMesh", "\"file\": \"part.stl\", ", "",
            "objects[0].mesh: names no mesh; add \"model\", \"file\" or \"shape\""},
        Bad{"ModelAndFile", "\"unit\"", "\"model\": \"bunny\", \"unit\"",
            "names a model and a file; keep one"},
        Bad{"ShortPosition", "[0, 80, 0]", "[0, 80]",
            "f.json:4: tools[0].start.position_mm: has 2 entries; give three"},
        Bad{"SameNames", "\"part\"", "\"probe\"", "objects[0].name: \"probe\" is taken"},
        Bad{"NameWithSpace", "\"part\"", "\"my part\"", "\"my part\" is not a name"},
        Bad{"EmptyName", "\"part\"", "\"\"", "objects[0].name: is empty"},
        Bad{"ListForObject", "{\"shape\": \"sphere\", \"radius_m\": 0.005}", "[1]",
            "tools[0].mesh: is a list; give an object"},
        Bad{"NoStiffness", "\"objects\"", "\"coupling\": {\"stiffness_N_per_m\": 0}, \"objects\"",
            "coupling.stiffness_N_per_m: 0.000000 is not allowed; give a number above 0"},
        Bad{"NotJson", "\"leaves\": 100", "\"leaves\" 100", "f.json:7: this is not JSON"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(SceneFile, RefusesEmptyLists) {
  EXPECT_THAT(ComplaintOf([] { ParseScene("{\"tools\": [], \"objects\": []}", "f.json"); }),
              HasSubstr("tools: has 0 entries; give at least 1"));
}

}  // namespace
}  // namespace palpate
