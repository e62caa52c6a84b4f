#include "scenes/files/scene_file.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/support.h"
#include "tests/support/refusals.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;

constexpr char kGood[] = R"({
  "tools": [
    {"name": "probe", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1,
     "start": {"position_mm": [0, 80, 0]}}
  ],
  "objects": [
    {"name": "part", "mesh": {"file": "part.stl", "unit": "mm"}, "leaves": 100}
  ]
})";

/// The good scene with one text replaced by another.
std::string Changed(const std::string& old_text, const std::string& new_text,
                    std::string text = kGood) {
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
  EXPECT_EQ(scene.tuning, StepTuning{});
}

TEST(SceneFile, CallsASceneByItsFileInLettersThatANameMayHave) {
  EXPECT_EQ(ParseScene(kGood, "a\x1b[31m\nready: b.json").name, "a--31m-ready--b");
  EXPECT_EQ(ParseScene(kGood, std::string(100, 'a') + ".json").name, std::string(64, 'a'));
}

TEST(SceneFile, TellsScenesApartWhoseNamesAreOfAnotherScript) {
  std::set<std::string> names;
  for (const char* stem : {"牙齿", "下颌", "зуб", "зуб 2", "歯", "1 个", "--é"}) {
    const std::string name = SceneNameOf(std::string("folder/") + stem + ".stl");
    EXPECT_TRUE(name.size() <= kLongestName && std::ranges::all_of(name, IsOfName)) << name;
    EXPECT_TRUE(names.insert(name).second) << name;
    EXPECT_EQ(SceneNameOf(std::string("other/") + stem + ".obj"), name) << "of the name alone";
  }
  EXPECT_EQ(SceneNameOf("Zähne.stl"), "Z--hne");
  EXPECT_EQ(SceneNameOf("7.stl"), "7");
}

/// A scene with so many of each, of which each body that is `cut` has a grid.
std::string WithMany(std::size_t tools, std::size_t objects, std::size_t cut, std::size_t effects) {
  const auto list = [](std::size_t count, const auto& entry) {
    std::string text;
    for (std::size_t i = 0; i < count; ++i) text += (i > 0 ? ",\n" : "\n") + entry(i);
    return " [" + text + "]";
  };
  const std::string ball = R"(", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1)";
  return R"({"tools":)" +
         list(tools,
              [&](std::size_t i) { return R"({"name": "t)" + std::to_string(i) + ball + "}"; }) +
         R"(, "objects":)" +
         list(objects,
              [&](std::size_t i) {
                const char* grid =
                    i < cut ? R"(, "grid_um": 50, "material": {"cutting_pressure_MPa": 10}})" : "}";
                return R"({"name": "o)" + std::to_string(i) + ball + grid;
              }) +
         R"(, "effects":)" +
         list(effects, [](std::size_t) { return std::string(R"({"name": "viscous"})"); }) + "}";
}

TEST(SceneFile, HoldsSoMuchOfEachAndNamesWhatIsMore) {
  const auto complaint = [](std::size_t tools, std::size_t objects, std::size_t cut,
                            std::size_t effects) {
    return ComplaintOf([&] { ParseScene(WithMany(tools, objects, cut, effects), "many.json"); });
  };
  EXPECT_EQ(complaint(kMostBodies, kMostBodies, kMostCutBodies, kMostEffects), "no complaint");
  EXPECT_THAT(complaint(2000, 1, 0, 0), testing::AllOf(HasSubstr("many.json:1: tools: "),
                                                       HasSubstr("2000"), HasSubstr("256")));
  EXPECT_THAT(complaint(1, kMostBodies + 1, 0, 0), HasSubstr(": objects: has 257"));
  EXPECT_THAT(complaint(1, 64, 64, 0),
              testing::AllOf(HasSubstr("objects[16].grid_um"), HasSubstr("16")));
  EXPECT_THAT(complaint(1, 1, 0, 20'000),
              testing::AllOf(HasSubstr("effects: "), HasSubstr("20000"), HasSubstr("64")));
}

TEST(SceneFile, ReadsEveryKindOfMeshAndCoupling) {
  const SceneDescription scene = ParseScene(R"({
    "name": "all", "description": "d",
    "coupling": {"stiffness_N_per_m": 500, "torsional_stiffness_Nm_per_rad": 0.5},
    "step": {"separation_um": 2, "sub_steps": 16},
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
  EXPECT_EQ(scene.tuning, (StepTuning{.separation = 2e-6, .sub_steps = 16}));
  EXPECT_EQ(scene.tools[0].mesh.size, Vec3(1, 2, 3));
  EXPECT_EQ(scene.objects[0].mesh.triangles, 99u);
  EXPECT_EQ(scene.objects[1].mesh.what, "bunny");
  EXPECT_EQ(scene.objects[1].mesh.placement.longest_side, 0.15);
  EXPECT_EQ(scene.objects[1].mesh.placement.origin, MeshPlacement::Origin::kCentroid);
  EXPECT_NEAR(std::abs(scene.objects[1].X_WB.q.z()), 1.0, 1e-12);
  EXPECT_EQ(scene.objects[2].mesh.what, "/x.ply");
  EXPECT_EQ(scene.objects[2].mesh.placement.metres_per_unit, 0.0254);
}

std::string WithObject(const std::string& fields) {
  return Changed("\"leaves\": 100", "\"leaves\": 100, " + fields);
}

TEST(SceneFile, ReadsHowTrulyAMeshStandsForACurvedSurface) {
  const auto curved = [](const std::string& field) {
    return ParseScene(Changed("\"unit\": \"mm\"", "\"unit\": \"mm\"" + field), "f.json")
        .objects[0]
        .mesh.curved;
  };
  EXPECT_FALSE(curved("").has_value()) << "triangles are taken as they are";
  EXPECT_FALSE(curved(", \"curved\": false").has_value());
  ASSERT_TRUE(curved(", \"curved\": {\"tolerance_um\": 2.5}").has_value());
  EXPECT_DOUBLE_EQ(curved(", \"curved\": {\"tolerance_um\": 2.5}")->tolerance, 2.5e-6);
  EXPECT_EQ(curved(", \"curved\": {\"tolerance_um\": 2.5}")->max_triangles,
            CurvedOptions{}.max_triangles);
  EXPECT_EQ(curved(", \"curved\": {\"tolerance_um\": 5, \"max_triangles\": 9000}")->max_triangles,
            9000u);
  // Every kind of mesh accepts it.
  const SceneDescription all = ParseScene(R"({
    "tools": [{"name": "a", "leaves": 8, "mesh": {"shape": "probe", "curved": {"tolerance_um": 1}}}],
    "objects": [
      {"name": "b", "leaves": 8, "mesh": {"shape": "ellipsoid", "semi_axes_m": [1, 2, 3],
                                          "curved": {"tolerance_um": 2}}},
      {"name": "c", "leaves": 8, "mesh": {"shape": "sphere", "radius_m": 1,
                                          "curved": {"tolerance_um": 3}}},
      {"name": "d", "leaves": 8, "mesh": {"shape": "box", "size_m": [1, 2, 3],
                                          "curved": {"tolerance_um": 4}}}]
  })",
                                          "f.json");
  EXPECT_EQ(all.tools[0].mesh.curved->tolerance, 1e-6);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(all.objects[i].mesh.curved->tolerance, (2.0 + i) * 1e-6);
  }
}

TEST(SceneFile, BalancesLeavesThatAreFeltUnlessItSaysOtherwise) {
  const auto with = [](const std::string& tree, const std::string& contact) {
    const SceneDescription scene =
        ParseScene(R"({"tools": [{"name": "t", "mesh": {"shape": "sphere", "radius_m": 0.01},
                                  "leaves": 8)" +
                       tree + R"(}], "objects": [{"name": "o", "leaves": 8,
                        "mesh": {"shape": "box", "size_m": [1, 1, 1]})" +
                       tree + "}]" + contact + "}",
                   "demo.json");
    EXPECT_EQ(scene.tools[0].tree, scene.objects[0].tree);
    return scene.objects[0].tree;
  };
  EXPECT_EQ(with("", ""), TreeMode::kInside);
  EXPECT_EQ(with("", R"(, "contact": "surface")"), TreeMode::kInside);
  EXPECT_EQ(with("", R"(, "contact": "spheres")"), TreeMode::kBalanced);
  EXPECT_EQ(with(R"(, "tree": "inside")", R"(, "contact": "spheres")"), TreeMode::kInside);
  EXPECT_EQ(with(R"(, "tree": "balanced")", ""), TreeMode::kBalanced);
}

TEST(SceneFile, ReadsHowTheSceneIsToBeSeen) {
  const std::string bodies = R"("tools": [{"name": "t", "leaves": 8, "look": "steel",
      "mesh": {"shape": "box", "size_m": [1, 1, 1]}}],
    "objects": [{"name": "o", "leaves": 8, "mesh": {"shape": "box", "size_m": [1, 1, 1]}}])";
  const SceneDescription scene = ParseScene(
      "{\"first_sight\": {\"centre_mm\": [0, 5, 0], \"radius_mm\": 30, \"from\": [0, 3, 4]}, " +
          bodies + "}",
      "f.json");
  EXPECT_EQ(scene.tools[0].look, "steel");
  EXPECT_EQ(scene.objects[0].look, "");
  ASSERT_TRUE(scene.first_sight.has_value());
  EXPECT_EQ(scene.first_sight->centre, Vec3(0, 0.005, 0));
  EXPECT_EQ(scene.first_sight->radius, 0.03);
  EXPECT_TRUE(scene.first_sight->from.isApprox(Vec3(0, 0.6, 0.8)));
}

TEST(SceneFile, TakesSurfaceContactAndNothingElseWhereNothingIsSaid) {
  const Features features = ParseScene(kGood, "f.json").features;
  EXPECT_EQ(features.contact, ContactModel::kSurface);
  EXPECT_EQ(features.friction, FrictionModel::kOff);
  EXPECT_FALSE(features.compliance);
}

TEST(SceneFile, ReadsMaterialsAndTheFeaturesThatFollow) {
  const SceneDescription scene =
      ParseScene(WithObject(R"("material": {"static_friction": 0.8, "dynamic_friction": 0.3},
        "regions": [
          {"box": {"min_mm": [0, 0, 0], "max_mm": [1, 2, 3]},
           "material": {"youngs_modulus_Pa": 5e6, "thickness_mm": 2}},
          {"sphere": {"centre_mm": [1, 2, 3], "radius_mm": 4}, "material": {"static_friction": 0.1}},
          {"group": "gum", "material": {"stiffness_N_per_m": 700, "dynamic_friction": 0.2}}])"),
                 "f.json");
  EXPECT_TRUE(scene.features.compliance);
  const BodyDescription& part = scene.objects[0];
  EXPECT_EQ(part.material.material.static_friction, 0.8);
  EXPECT_EQ(part.material.material.dynamic_friction, 0.3);
  EXPECT_TRUE(std::isinf(part.material.material.stiffness));
  ASSERT_EQ(part.regions.size(), 3u);
  EXPECT_NEAR(part.regions[0].box.max().z(), 0.003, 1e-15);
  EXPECT_EQ(part.regions[0].material.youngs_modulus, 5e6);
  EXPECT_EQ(part.regions[0].material.thickness, 0.002);
  EXPECT_EQ(part.regions[1].ball.radius, 0.004);
  EXPECT_EQ(part.regions[1].material.material.static_friction, 0.1);
  EXPECT_EQ(part.regions[2].group, "gum");
  EXPECT_EQ(part.regions[2].material.material.stiffness, 700);
  EXPECT_EQ(part.regions[2].material.material.static_friction, 0.2);
}

TEST(SceneFile, BeginsWholeWhereItSaysSoAndSomethingIsCut) {
  const auto with = [](const std::string& word, const std::string& material) {
    std::string text = WithObject(material);
    return text.insert(1, "\"whole_at_start\": " + word + ", ");
  };
  const std::string wears = R"("grid_um": 100, "material": {"cutting_pressure_MPa": 1})";
  EXPECT_TRUE(ParseScene(with("true", wears), "f.json").whole_at_start);
  EXPECT_FALSE(ParseScene(with("false", wears), "f.json").whole_at_start);
  EXPECT_FALSE(ParseScene(kGood, "f.json").whole_at_start);
}

TEST(SceneFile, ReadsContactAndFriction) {
  const std::string frictional = WithObject("\"material\": {\"static_friction\": 0.5}");
  const auto features = [&](const std::string& fields) {
    std::string text = frictional;
    return ParseScene(text.insert(1, fields), "f.json").features;
  };
  EXPECT_EQ(features("\"contact\": \"spheres\",").contact, ContactModel::kSpheres);
  EXPECT_EQ(features("\"contact\": \"surface\",").contact, ContactModel::kSurface);
  EXPECT_EQ(features("\"friction\": \"off\",").friction, FrictionModel::kOff);
  EXPECT_EQ(features("\"friction\": \"chapter\",").friction, FrictionModel::kChapter);
  EXPECT_EQ(features("\"friction\": \"coulomb\",").friction, FrictionModel::kCoulomb);
}

TEST(SceneFile, ReadsWhatMoves) {
  std::string text = WithObject("\"moved\": \"jaw\"");
  const std::string moved =
      "\"moved\": [{\"name\": \"jaw\", \"point_mm\": [1, 2, 3], \"axis\": [0, 2, 0], \"motion\": "
      "\"steady\", \"repeats\": true, \"keys\": [{\"t\": 0}, {\"t\": 1.5, \"turn_deg\": 90, "
      "\"shift_mm\": [0, 0, 4]}, {\"t\": 3}]}],";
  const SceneDescription scene = ParseScene(text.insert(1, moved), "f.json");
  ASSERT_EQ(scene.moved.size(), 1u);
  EXPECT_EQ(scene.objects[0].moved, 1u);
  const MovedGroup& jaw = scene.moved[0];
  EXPECT_EQ(jaw.name, "jaw");
  EXPECT_TRUE(jaw.point.isApprox(Vec3(1e-3, 2e-3, 3e-3)));
  EXPECT_TRUE(jaw.axis.isApprox(Vec3::UnitY()));
  EXPECT_FALSE(jaw.smooth);
  EXPECT_TRUE(jaw.repeats);
  ASSERT_EQ(jaw.keys.size(), 3u);
  EXPECT_EQ(jaw.keys[1].at, 1500);
  EXPECT_NEAR(jaw.keys[1].turn, 0.5 * M_PI, 1e-15);
  EXPECT_TRUE(jaw.keys[1].shift.isApprox(Vec3(0.0, 0.0, 4e-3)));
}

TEST(SceneFile, RefusesWithLineFieldAndRemedy) {
  test::ExpectRefusals("tests/scenes/files/scene_file.refusals", [](const auto& inputs) {
    std::string text = kGood;
    for (std::size_t i = 0; i < inputs.size(); i += 2)
      text = Changed(inputs[i], inputs.at(i + 1), text);
    return ComplaintOf([&] { ParseScene(text, "f.json"); });
  });
}

}  // namespace
}  // namespace palpate
