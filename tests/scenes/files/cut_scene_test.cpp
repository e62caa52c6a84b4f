#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/catalogue.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/files/scene_file.h"
#include "scenes/scene_verdict.h"
#include "server/physics/haptic_step.h"
#include "server/physics/limits.h"
#include "server/physics/scene_model.h"
#include "tests/support/complaint.h"
#include "tests/support/folder.h"
#include "tests/support/refusals.h"
#include "tests/support/volume_left.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;

const std::string kBallBur =
    R"({"shape": "bur", "kind": "ball", "diameter_mm": 1.0, "handle_mm": 40})";
const std::string kEnamelOnDentine = R"("grid_um": 100,
  "material": {"cutting_pressure_MPa": 0.2, "cutting_viscosity_MPa_s_per_mm": 0.05},
  "regions": [{"box": {"min_mm": [-9, 0.5, -9], "max_mm": [9, 9, 9]},
               "material": {"cutting_pressure_MPa": 0.6}}])";

std::string SceneOf(const std::string& tool, const std::string& block) {
  return R"({"tools": [{"name": "bur", "leaves": 16, )" + tool +
         R"(, "start": {"position_mm": [0, 3, 0]}}],
 "objects": [{"name": "block", "mesh": {"shape": "box", "size_m": [0.004, 0.003, 0.004]}, )" +
         block + R"(},
  {"name": "table", "leaves": 8, "mesh": {"shape": "box", "size_m": [0.02, 0.002, 0.02]},
   "pose": {"position_mm": [0, -3, 0]}}]})";
}

std::string SceneText(const std::string& mesh, const std::string& block) {
  return SceneOf("\"mesh\": " + mesh, block);
}

Scene Load(const std::string& text) {
  const test::Folder folder;
  const std::string file = folder / "s.json";
  std::ofstream(file) << text;
  LoadOptions options;
  options.use_cache = false;
  return LoadScene(file, options);
}

TEST(CutScene, GoesWholeThroughABundle) {
  const Scene scene = Load(SceneText(kBallBur, kEnamelOnDentine));
  const std::vector<std::uint8_t> bytes = PackScene(scene, 7);
  const Scene back = UnpackScene(bytes, "s");
  EXPECT_EQ(PackScene(back, 7), bytes);
  ASSERT_TRUE(back.tools[0].bur.has_value());
  EXPECT_EQ(back.tools[0].bur->rounding, 0.5e-3);
  ASSERT_TRUE(back.objects[0].grid.has_value());
  EXPECT_FALSE(back.objects[1].grid.has_value());
  EXPECT_NEAR(back.objects[0].grid->spacing, 100e-6, 1e-12);
  ASSERT_EQ(back.objects[0].materials.size(), 2u);
  EXPECT_NEAR(back.objects[0].materials[0].cutting_pressure, 0.2e6, 1e-6);
  EXPECT_NEAR(back.objects[0].materials[0].cutting_viscosity, 0.05e9, 1e-3);
  EXPECT_NEAR(back.objects[0].materials[1].cutting_pressure, 0.6e6, 1e-6);
  ASSERT_EQ(back.objects[0].grid->regions.size(), 1u);
  EXPECT_TRUE(back.objects[0].grid->regions[0].Holds(Vec3(0, 1e-3, 0)));
  EXPECT_FALSE(back.objects[0].grid->regions[0].Holds(Vec3(0, 0.4e-3, 0)));
}

const std::string kCore = R"("grid_um": 100, "material": {"cutting_pressure_MPa": 0.2},
  "regions": [{"mesh": {"shape": "sphere", "radius_m": 0.001},
               "material": {"cutting_pressure_MPa": 0.6, "colour": "#8A5a2b",
               "name": "caries"}}])";

TEST(CutScene, PaintsWhatLiesWithinAMeshAlsoAfterABundle) {
  const Scene scene = Load(SceneText(kBallBur, kCore));
  const std::vector<std::uint8_t> bytes = PackScene(scene, 7);
  const Scene back = UnpackScene(bytes, "s");
  EXPECT_EQ(PackScene(back, 7), bytes);
  EXPECT_EQ(back.objects[0].materials[0].colour, Material::kNoColour);
  EXPECT_EQ(back.objects[0].materials[1].colour, 0x8a5a2bu);
  EXPECT_EQ(back.objects[0].materials[0].name, "");
  EXPECT_EQ(back.objects[0].materials[1].name, "caries");
  const auto grid = MakeSolidGrid(back.objects[0]);
  EXPECT_EQ(grid->Material(Vec3(0.9e-3, 0, 0)), 1);
  EXPECT_EQ(grid->Material(Vec3(1.1e-3, 0, 0)), 0);
  Scene open = scene;
  open.objects[0].grid->regions[0].mesh.triangles.pop_back();
  EXPECT_THAT(ComplaintOf([&] { UnpackScene(PackScene(open), "s"); }),
              HasSubstr("a region: the mesh is open"));
}

TEST(CutScene, NamesTheRegionWhoseMeshEnclosesNothing) {
  const test::Folder folder;
  const std::string file = folder / "s.json";
  std::ofstream(folder / "sheet.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  std::ofstream(file) << SceneText(kBallBur, R"("grid_um": 100,
    "material": {"cutting_pressure_MPa": 0.2}, "regions": [
    {"mesh": {"file": "sheet.obj", "unit": "mm"}, "material": {"cutting_pressure_MPa": 1}}])");
  EXPECT_THAT(ComplaintOf([&] { LoadScene(file); }),
              testing::AllOf(HasSubstr("s.json:4: objects[0].regions[0].mesh: "),
                             HasSubstr("the mesh is open at 3 edges"), HasSubstr("thickness")));
}

// A cycle's cost must not grow with the hand's speed: the bur lags instead, and the material it has
// reached holds the hand back.
TEST(CutScene, ABurThatIsAllInTheMaterialGoesNoFartherInACycleThanItsTimeAllows) {
  const Scene scene =
      Load(SceneText(R"({"shape": "bur", "kind": "ball", "diameter_mm": 1.4, "handle_mm": 40})",
                     R"("grid_um": 50, "material": {"cutting_pressure_MPa": 0.05})"));
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  StepState state(model);
  StepWorkspace workspace(model);
  const double y = 0.27e-3;  // most of the ball below the face, and none of its neck
  state.X_WG = state.X_WH = {Vec3(-1.2e-3, y, 0)};
  int cutting = 0;
  double force = 0.0;
  for (double x = -1.2e-3; x < 1.2e-3; x += 0.4e-3) {  // 0.4 m/s
    const std::uint32_t before = state.cut.fields[0].changes();
    const StepReport report = HapticStep(model, {Vec3(x, y, 0)}, state, workspace);
    EXPECT_LE(report.diagnostics.substeps, 3) << x;  // of 8
    cutting += state.cut.fields[0].changes() > before;
    force = std::max(force, report.wrench.force.norm());
  }
  EXPECT_GE(cutting, 3);
  // The law's force at rest, plus what a bur that tilts back a little adds.
  EXPECT_NEAR(force, M_PI * 0.49e-6 * 0.05e6, 0.01);
}

TEST(CutScene, NamesTheFieldAndTheRemedyOfWhatCannotBeCut) {
  test::ExpectRefusals("tests/scenes/files/cut_scene.refusals", [](const auto& inputs) {
    const bool plain = inputs.at(1) == "BLOCK";
    std::string text = SceneOf(inputs.at(0), plain ? kEnamelOnDentine : inputs.at(1));
    if (inputs.size() > 2) text.insert(1, inputs[2]);
    return ComplaintOf([&] { Load(text); });
  });
}

TEST(CutScene, ANamedBurHasItsHeadItsMeshAndItsSpinAlsoAfterABundle) {
  const Scene scene = Load(SceneOf(
      R"("bur": "237/014", "speed_rpm": 3000, "vibration": {"teeth": 6, "share": 0.2})",
      R"("grid_um": 100, "material": {"cutting_pressure_MPa": 0.2, "cutting_friction": 0.3})"));
  const std::vector<std::uint8_t> bytes = PackScene(scene, 7);
  const Scene back = UnpackScene(bytes, "s");
  EXPECT_EQ(PackScene(back, 7), bytes);
  EXPECT_GT(back.tools[0].mesh.triangles.size(), 500u);
  EXPECT_EQ(back.objects[0].materials[0].cutting_friction, 0.3);
  const HapticModel model = MakeModel(back, back.tools[0], MakeObjects(back));
  EXPECT_NEAR(model.cutting()->bur.radius(), 0.7e-3, 1e-12);
  EXPECT_NEAR(model.cutting()->bur.high() - model.cutting()->bur.low(), 2e-3, 1e-12);
  EXPECT_NEAR(model.cutting()->spin.speed, 100.0 * M_PI, 1e-6);
  EXPECT_EQ(model.cutting()->spin.tooth_Hz, 300.0);
  EXPECT_EQ(model.cutting()->spin.vibration, 0.2);
  EXPECT_EQ(model.solids()[0].materials[0].cutting_friction, 0.3);
  for (const BurSample& sample : model.bur_samples()) {
    // The bur turns about y, clockwise from above, and its surface moves no faster than that.
    EXPECT_NEAR(sample.slide.norm(), 1.0, 1e-12);
    EXPECT_NEAR(sample.slide.dot(sample.normal), 0.0, 1e-12);
    const Vec3 place = sample.point + model.reference();
    EXPECT_LT(place.cross(sample.slide).y(), 0.0);
  }
}

/// An edge on the lower half of a ball of 1 mm.
std::string EdgeOf(const std::string& curve, const std::string& rounding, const std::string& at,
                   const std::string& sense = "[2, 0, 0]") {
  return R"("mesh": {"shape": "sphere", "radius_m": 0.001}, "edge": {"curve_mm": )" + curve +
         R"(, "rounding_mm": )" + rounding + R"(, "at_mm": )" + at +
         R"(, "along": [0, 2, 0], "sense": )" + sense + "}";
}

TEST(CutScene, AnEdgeOfAnyMeshIsTheSameAfterABundle) {
  const Scene scene = Load(
      SceneOf(EdgeOf("[[0, 0], [0.1, 0.6], [0, 0.6]]", "1", "[0, -0.1, 0]"), kEnamelOnDentine));
  const std::vector<std::uint8_t> bytes = PackScene(scene, 7);
  const Scene back = UnpackScene(bytes, "s");
  EXPECT_EQ(PackScene(back, 7), bytes);
  const HapticModel model = MakeModel(back, back.tools[0], MakeObjects(back));
  ASSERT_TRUE(model.cutting()->sense.has_value());
  EXPECT_EQ(*model.cutting()->sense, Vec3::UnitX());
  EXPECT_NEAR((model.cutting()->X_TB * Vec3(0, 0, 1e-3) - Vec3(0, 0.9e-3, 0)).norm(), 0.0, 1e-12);
  for (const BurSample& sample : model.bur_samples()) {
    EXPECT_EQ(sample.cuts, sample.normal.x() > -limits::cutting::kRelief);
    EXPECT_TRUE(sample.slide.isZero(0.0));
  }
}

TEST(CutScene, ACurveInPlaceOfAKindIsTheBurThatItTurns) {
  const Scene scene = Load(SceneText(
      R"({"shape": "bur", "curve_mm": [[0, 0], [0.4, 0.2], [0.5, 1], [0, 1.4]], "rounding_mm": 0.05,
          "dead_tip_mm": 0.1, "cutting_mm": 1})",
      kEnamelOnDentine));
  const Scene back = UnpackScene(PackScene(scene), "s");
  const HapticModel model = MakeModel(back, back.tools[0], MakeObjects(back));
  EXPECT_NEAR(model.cutting()->bur.radius(), 0.55e-3, 1e-12);
  EXPECT_NEAR(model.cutting()->bur.high() - model.cutting()->bur.low(), 1.5e-3, 1e-12);
  int cut = 0;
  for (const BurSample& sample : model.bur_samples()) {
    const double y = sample.point.y() + model.reference().y();
    EXPECT_EQ(sample.cuts, y >= 0.1e-3 && y <= 1e-3) << y;
    cut += sample.cuts;
  }
  EXPECT_GT(cut, 100);
}

TEST(CutScene, IsNotUsableWhereAGridCannotBeMadeOrAToolIsNoBur) {
  Scene scene = Load(SceneText(kBallBur, kEnamelOnDentine));
  EXPECT_TRUE(JudgeScene(scene).usable());
  Scene open = scene;
  open.objects[0].mesh.triangles.pop_back();
  EXPECT_THAT(JudgeScene(open).faults,
              testing::ElementsAre(HasSubstr("object block: the mesh is open at 3 edges")));
  Scene huge = scene;
  huge.objects[0].grid->spacing = 25e-6;
  for (Vec3& v : huge.objects[0].mesh.vertices) v *= 50.0;
  EXPECT_THAT(JudgeScene(huge).faults, testing::ElementsAre(HasSubstr("use a larger spacing")));
  // A tool may not pass through what it does not feel.
  scene.tools[0].bur.reset();
  EXPECT_NO_THROW(MakeModel(scene, scene.tools[0], MakeObjects(scene)));
  scene.features.contact = ContactModel::kSpheres;
  EXPECT_THAT(ComplaintOf([&] { MakeModel(scene, scene.tools[0], MakeObjects(scene)); }),
              HasSubstr("a tool without a bur"));
}

TEST(CutScene, RefusesABundleWhoseGridOrBurIsNone) {
  const Scene good = Load(SceneText(kBallBur, kEnamelOnDentine));
  const auto complaint = [&](auto spoil) {
    Scene scene = good;
    spoil(scene);
    return ComplaintOf([&] { UnpackScene(PackScene(scene), "s"); });
  };
  EXPECT_THAT(complaint([](Scene& s) { s.objects[0].grid->spacing = 1e-6; }),
              HasSubstr("a grid is none"));
  EXPECT_THAT(complaint([](Scene& s) { s.objects[0].materials[1].cutting_pressure = 0.0; }),
              HasSubstr("a cutting material is invalid"));
  EXPECT_THAT(complaint([](Scene& s) { s.objects[0].grid->regions[0].material = 2; }),
              HasSubstr("a region is invalid"));
  EXPECT_THAT(
      complaint([](Scene& s) { s.objects[0].materials.resize(9, s.objects[0].materials[0]); }),
      HasSubstr("a grid is none"));
  EXPECT_THAT(complaint([](Scene& s) { s.tools[0].bur->curve.clear(); }),
              HasSubstr("a bur is none"));
  EXPECT_THAT(complaint([](Scene& s) { s.tools[0].bur->spin.speed = std::nan(""); }),
              HasSubstr("a bur is none"));
  EXPECT_THAT(complaint([](Scene& s) { s.objects[0].materials[1].cutting_friction = 9.0; }),
              HasSubstr("a friction is invalid"));
}

}  // namespace
}  // namespace palpate
