#include "client/replayer/score/cut_measures.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>

#include "client/replayer/score/cut_picture.h"
#include "scenes/shapes/bur_shapes.h"
#include "scenes/shapes/shapes.h"
#include "scenes/shapes/swept_mesh.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "server/physics/scene_model.h"
#include "tests/support/complaint.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

constexpr double kMm = 1e-3, kRadius = 3.0, kHeight = 5.0;

/// An upright cylinder standing on the origin [mm], of enamel with a ball of pulp in it.
SolidsCut Stock(const MaterialRegion& pulp) {
  Body body;
  body.name = "post";
  body.mesh =
      MakeRod({Vec3::Zero(), kMm * kHeight * Vec3::UnitY()}, {kMm * kRadius, kMm * kRadius}, 180);
  body.tree = BuildInnerTree(body.mesh);
  body.grid = BodyGrid{.spacing = 100e-6, .regions = {pulp}};
  body.materials = {Material{.name = "enamel"}, Material{.name = "pulp"}};
  for (Material& material : body.materials) material.cutting_pressure = 1e5;
  auto scene = std::make_shared<Scene>();
  scene->name = "post";
  scene->objects = {body};
  SolidsCut cut{scene, MakeObjects(*scene), {}, {}};
  cut.before.emplace_back(*cut.objects->solids[0].grid, kMostGridBytes, "post");
  cut.after = cut.before;
  return cut;
}
SolidsCut Stock() {
  return Stock({.low = kMm * Vec3(0, 1.5, 0), .radius = 0.8 * kMm, .material = 1});
}

/// Moves an upright bur, whose tip goes straight from one of these points [mm] to the next.
void Cut(SolidsCut& cut, const BurProfile& profile, const std::vector<Vec3>& tips) {
  const Bur bur(profile.curve, profile.rounding);
  const Quat z_to_y(std::sqrt(0.5), -std::sqrt(0.5), 0.0, 0.0);
  for (std::size_t i = 1; i < tips.size(); ++i) {
    const Vec3 from = kMm * tips[i - 1], way = kMm * (tips[i] - tips[i - 1]);
    // No step is longer than the field's band.
    const int steps = static_cast<int>(std::ceil(way.norm() / 0.1e-3));
    for (int k = 0; k < steps; ++k) {
      const Vec3 at = from + way * k / steps + profile.rounding * Vec3::UnitY();
      ASSERT_FALSE(cut.after[0].Remove(bur, {at, z_to_y}, way / steps).full);
    }
  }
}

/// Goes once round the axis with the bur's axis `radius` away; in the second half higher by `step`
/// [mm].
std::vector<Vec3> Ring(double radius, double height, double step = 0.0) {
  std::vector<Vec3> tips{Vec3(6, height, 0)};
  constexpr int kCount = 400;
  for (int i = 0; i <= kCount; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kCount;
    const double y = height + (2 * i > kCount ? step : 0.0);
    tips.emplace_back(radius * std::cos(angle), y, radius * std::sin(angle));
  }
  return tips;
}

std::vector<Vec3> Plunge(double x, double depth) {
  return {Vec3(x, 6, 0), Vec3(x, depth, 0)};
}

const Place kMargin = MaterialRegion{.low = Vec3(-0.01, 0, -0.01), .high = Vec3(0.01, 0.003, 0.01)};
/// Radius 0.6 mm at the tip, with edges rounded by 0.1 mm, growing by 0.25 mm along 5.8 mm of the
/// side.
const BurProfile kTapered = ConeBur(0.6 * kMm, 0.85 * kMm, 6.0 * kMm, 0.1 * kMm);
const double kTaper = std::atan(0.25 / 5.8) * 180.0 / std::numbers::pi;

// A cone that goes round a cylinder leaves a wall that leans as the cone's side does, over a flat
// shoulder with a fillet of the bur's rounding; the wall counts the half of the fillet that is
// steeper than 45 degrees.
TEST(CutMeasures, FindTheTaperAndTheMarginThatAConeLeavesRoundACylinder) {
  SolidsCut cut = Stock();
  constexpr double kAway = 2.8;
  Cut(cut, kTapered, Ring(kAway, 2.0));
  const CutShape shape(cut);
  const Preparation found = shape.PreparationAlong(Vec3::UnitY(), kMargin);
  ASSERT_TRUE(found.taper_deg && found.width_mm);
  EXPECT_NEAR(*found.taper_deg, kTaper, 0.1);
  EXPECT_LT(found.undercut_share, 0.02);
  const double foot = kAway - 0.6 + 0.1 * (1.0 - std::sqrt(0.5));
  EXPECT_NEAR(*found.width_mm, kRadius - foot, 0.02);
  EXPECT_LT(found.spread_mm, 0.02);
  EXPECT_LT(found.roughness_mm, 0.01);
  // For the wall alone the axis makes no difference: turned by 10 degrees it leans away from one
  // half of it.
  EXPECT_NEAR(*shape.PreparationAlong(Vec3::UnitY(), std::nullopt).taper_deg, kTaper, 0.1);
}

TEST(CutMeasures, FindTheUndercutOfAnInvertedConeAndTheStepInAMargin) {
  SolidsCut inverted = Stock();
  Cut(inverted, ConeBur(0.85 * kMm, 0.6 * kMm, 6.0 * kMm, 0.1 * kMm), Ring(2.8, 2.0));
  // The wall alone, above the fillet and below the top.
  const Place wall = MaterialRegion{.low = Vec3(-1, 2.3e-3, -1), .high = Vec3(1, 4.8e-3, 1)};
  const Preparation found = CutShape(inverted).PreparationAlong(Vec3::UnitY(), wall);
  EXPECT_NEAR(found.taper_deg.value_or(0.0), -kTaper, 0.15);
  EXPECT_GT(found.undercut_share, 0.95);
  SolidsCut stepped = Stock();
  Cut(stepped, kTapered, Ring(2.8, 2.0, 0.4));
  const Preparation step = CutShape(stepped).PreparationAlong(Vec3::UnitY(), kMargin);
  // Two steps of 0.4: ramps from 0.2 to 0 over 10 degrees to either side of each, whose rms is
  // 0.115.
  EXPECT_NEAR(step.roughness_mm, 0.115 * std::sqrt(40.0 / 360.0), 0.01);
}

TEST(CutMeasures, FindNothingWhereNothingWasCut) {
  const SolidsCut cut = Stock();
  const Preparation found = CutShape(cut).PreparationAlong(Vec3::UnitY(), std::nullopt);
  EXPECT_FALSE(found.taper_deg || found.width_mm);
}

TEST(CutMeasures, FindTheThicknessOverABallOfPulp) {
  const BurProfile ball = BallBur(0.7 * kMm);
  for (const double x : {0.0, 0.5}) {
    SolidsCut cut = Stock();
    Cut(cut, ball, Plunge(x, 3.1));
    EXPECT_NEAR(*CutShape(cut).ThicknessOver("pulp", std::nullopt),
                std::hypot(x, 3.8 - 1.5) - 0.7 - 0.8, 0.006);
  }
  SolidsCut opened = Stock();
  Cut(opened, ball, Plunge(0.0, 2.0));
  EXPECT_EQ(*CutShape(opened).ThicknessOver("pulp", std::nullopt), 0.0);
  EXPECT_FALSE(CutShape(opened).ThicknessOver("pulp", MaterialRegion{.radius = 1e-6}));
  // Where nothing was cut, it is measured from the nearest surface: the bottom.
  EXPECT_NEAR(*CutShape(Stock()).ThicknessOver("pulp", std::nullopt), 0.7, 0.006);
  EXPECT_THAT(ComplaintOf([&] { (void)CutShape(opened).ThicknessOver("enamel", std::nullopt); }),
              HasSubstr("no region of the scene paints 'enamel'"));
}

TEST(CutMeasures, FindTheThicknessOverAMeshAndABox) {
  MaterialRegion pulp{.material = 1, .mesh = MakeSphere(0.8 * kMm, 2000)};
  for (Vec3& v : pulp.mesh.vertices) v += kMm * Vec3(0, 1.5, 0);
  SolidsCut cut = Stock(pulp);
  Cut(cut, BallBur(0.7 * kMm), Plunge(0.0, 3.1));
  EXPECT_NEAR(*CutShape(cut).ThicknessOver("pulp", std::nullopt), 0.8, 0.01);
  SolidsCut box =
      Stock({.low = kMm * Vec3(-1, 1, -1), .high = kMm * Vec3(1, 2.5, 1), .material = 1});
  Cut(box, BallBur(0.7 * kMm), Plunge(0.0, 3.1));
  EXPECT_NEAR(*CutShape(box).ThicknessOver("pulp", std::nullopt), 0.6, 0.006);
}

TEST(CutMeasures, CountEachTissueInAPlaceAndWhatDiffersFromATarget) {
  SolidsCut target = Stock(), deeper = Stock();
  Cut(target, BallBur(0.7 * kMm), Plunge(0.0, 3.4));
  Cut(deeper, BallBur(0.7 * kMm), Plunge(0.0, 2.0));
  const double section = std::numbers::pi * 0.49;
  const TargetDifference more = DifferenceTo(target, deeper, "", std::nullopt);
  EXPECT_NEAR(more.excess_mm3, section * 1.4, 0.01 * section * 1.4);
  EXPECT_NEAR(more.missed_mm3, 0.0, 0.001);
  const TargetDifference less = DifferenceTo(deeper, target, "", std::nullopt);
  EXPECT_EQ(less.missed_mm3, more.excess_mm3);
  const double pulp = DifferenceTo(target, deeper, "pulp", std::nullopt).excess_mm3;
  const auto tissues = TissuesOf(deeper);
  ASSERT_EQ(tissues.size(), 2u);
  EXPECT_EQ(tissues[1].name, "pulp");
  EXPECT_NEAR(tissues[1].removed_mm3(), pulp, 1e-6);
  EXPECT_GT(pulp, 0.05);
  const double ball = 4.0 / 3.0 * std::numbers::pi * 0.512;
  EXPECT_NEAR(tissues[1].before_mm3, ball, 0.02 * ball) << "a voxel is all of its point's material";
  // Up there the plunge is a cylinder.  A place takes whole voxels, those whose points lie in it.
  const Place top = MaterialRegion{.low = Vec3(-1, 4.2e-3, -1), .high = Vec3(1, 1, 1)};
  EXPECT_NEAR(TissuesOf(deeper, top)[0].removed_mm3(), section * 0.8, section * 0.05);
}

TEST(CutPicture, TellsHowFarASurfaceIsOffItsTarget) {
  for (const double deeper_mm : {0.2, 0.45, 0.85}) {  // within the grid's band, and beyond it
    SolidsCut target = Stock(), deeper = Stock();
    Cut(target, ConeBur(0.7 * kMm, 0.7 * kMm, 4 * kMm, 0.1 * kMm), Plunge(0.0, 3.0));
    Cut(deeper, ConeBur(0.7 * kMm, 0.7 * kMm, 4 * kMm, 0.1 * kMm), Plunge(0.0, 3.0 - deeper_mm));
    const CutPicture excess = PictureOf(deeper, SurfacesOf(deeper), target, SurfacesOf(target));
    ASSERT_EQ(excess.off.size(), excess.vertices.size());
    const double most = std::min(deeper_mm * kMm, kMostOff);
    EXPECT_NEAR(std::ranges::min(excess.off), -most, 0.01 * kMm);
    EXPECT_LT(std::ranges::max(excess.off), 0.05 * kMm) << "an edge's vertices are of both faces";
    EXPECT_NEAR(
        std::ranges::max(PictureOf(target, SurfacesOf(target), deeper, SurfacesOf(deeper)).off),
        most, 0.01 * kMm);
    EXPECT_LT(excess.vertices.size(), 20'000u);
  }
}

}  // namespace
}  // namespace palpate::test
