#include "scenes/shapes/tooth_forms.h"

#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include "scenes/catalogue.h"
#include "scenes/files/scene_file.h"
#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

/// Height at which a ray down the tooth's axis meets it [mm].
double TopAt(const Field& tooth, double x, double z) {
  double y = 14.0;
  for (const double step : {0.2, 0.02}) {  // no part of a crown is thinner than 0.2 mm
    y += step;
    while (y > -3.0 && tooth({x, y, z}) > 0.0) y -= step;
  }
  return y;
}

/// Counts the peaks of the chewing surface that are highest within a millimetre.
int CuspsOf(ToothNumber number) {
  const ToothMeasures size = MeasuresOf(number);
  const Field tooth = ToothFormField(number, size);
  constexpr double kStep = 0.2;
  const int n = int(0.5 * std::max(size.width, size.depth) / kStep);
  std::map<std::pair<int, int>, double> tops;
  for (int i = -n; i <= n; ++i) {
    for (int k = -n; k <= n; ++k) tops[{i, k}] = TopAt(tooth, kStep * i, kStep * k);
  }
  int cusps = 0;
  for (const auto& [at, top] : tops) {
    bool highest = top > 0.6 * size.crown;
    for (int di = -5; di <= 5 && highest; ++di) {
      for (int dk = -5; dk <= 5 && highest; ++dk) {
        const std::pair<int, int> other{at.first + di, at.second + dk};
        if (other == at || !tops.contains(other)) continue;
        highest = tops[other] < top || (tops[other] == top && at < other);
      }
    }
    cusps += highest;
  }
  return cusps;
}

TEST(ToothForms, AreToldApartByTheirCusps) {
  EXPECT_EQ(CuspsOf({1, 3}), 1);
  EXPECT_EQ(CuspsOf({1, 4}), 2);
  EXPECT_EQ(CuspsOf({4, 5}), 2);
  EXPECT_EQ(CuspsOf({1, 6}), 4);
  EXPECT_EQ(CuspsOf({3, 6}), 5);  // three of them on the outer side
  EXPECT_EQ(CuspsOf({3, 7}), 4);
}

TEST(ToothForms, HaveTheRootsOfTheirKind) {
  const auto roots = [](ToothNumber number) {
    const ToothMeasures size = MeasuresOf(number);
    const Field tooth = ToothFormField(number, size);
    const double y = -0.75 * size.root;
    const double b = 0.5 * size.depth;
    const double a = 0.5 * size.width;
    // Looks for roots at the places of upper and lower molars' roots, and in the middle.
    int found = tooth({0, y, 0}) < 0.0;
    for (const double x : {-1.0, 1.0}) {
      found += tooth({0.57 * a * x, y, 0.38 * b}) < 0.0;
      found += tooth({0.5 * a * x, y, -0.05 * b}) < 0.0 && tooth({0.57 * a * x, y, 0.38 * b}) > 0.0;
    }
    return found + (tooth({0, y, -0.62 * b}) < 0.0);
  };
  EXPECT_EQ(roots({1, 1}), 1);
  EXPECT_EQ(roots({2, 6}), 3);
  EXPECT_EQ(roots({4, 6}), 2);
}

TEST(ToothForms, OfTheTwoSidesMirrorEachOther) {
  for (int place = 1; place <= 7; ++place) {
    const ToothMeasures size = MeasuresOf({1, place});
    const Field right = ToothFormField({1, place}, size);
    const Field left = ToothFormField({2, place}, size);
    for (const double x : {-3.0, -1.0, 0.5, 2.5}) {
      EXPECT_EQ(right({x, 4.0, 1.0}), left({-x, 4.0, 1.0}));
    }
  }
}

TEST(ToothForms, NamesCountThroughTheQuadrants) {
  ASSERT_EQ(ToothNames().size(), 28u);
  for (std::size_t i = 0; i < ToothNames().size(); ++i) {
    const ToothNumber n = NumberOf(i);
    EXPECT_EQ(ToothNames()[i], std::to_string(n.quadrant) + std::to_string(n.place));
  }
}

TEST(ToothForms, StandInTheOralCavityWhereTheGumHasThem) {
  const std::string file = FindSceneFile("oral-cavity");
  const SceneDescription scene = ParseScene(ReadWholeFile(file), file);
  int teeth = 0;
  for (const bool upper : {true, false}) {
    const auto jaw = std::find_if(scene.objects.begin(), scene.objects.end(), [&](const auto& o) {
      return o.name == (upper ? "upper-jaw" : "lower-jaw");
    });
    ASSERT_NE(jaw, scene.objects.end());
    for (const PlacedTooth& placed : TeethOf(upper)) {
      const Vec3 should = jaw->X_WB.p + jaw->X_WB.q * Vec3(1e-3 * placed.x, 0.0, 1e-3 * placed.z);
      for (const BodyDescription& object : scene.objects) {
        if (object.mesh.what != "tooth") continue;
        const ToothNumber is = NumberOf(object.mesh.variant - 4);  // after the four simple ones
        if (is.quadrant != placed.number.quadrant || is.place != placed.number.place) continue;
        ++teeth;
        EXPECT_LT((object.X_WB.p - should).norm(), 5e-4) << object.name;
        const Vec3 out = jaw->X_WB.q * Vec3(std::sin(placed.angle), 0.0, std::cos(placed.angle));
        EXPECT_GT((object.X_WB.q * Vec3::UnitZ()).dot(out), 0.995) << object.name;
      }
    }
  }
  EXPECT_EQ(teeth, 28);
}

}  // namespace
}  // namespace palpate
