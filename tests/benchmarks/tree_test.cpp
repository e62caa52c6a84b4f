
#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere.h"
#include "tests/benchmarks/bench_fixture.h"
#include "tests/support/dirty_mesh.h"

namespace palpate {
namespace {

using test::PalpateBench;
using testing::ElementsAre;
using testing::HasSubstr;

// A box away from its file's origin, in millimetres.
const Vec3 kMiddle_mm(100.0, -30.0, 7.0), kSides_mm(20.0, 30.0, 40.0);

void WriteBox(const std::string& file) {
  std::ofstream(file) << test::ObjOf(test::Moved(MakeBox(kSides_mm), kMiddle_mm));
}

std::vector<Sphere> ReadBalls(const std::string& file) {
  std::ifstream in(file);
  std::vector<Sphere> balls;
  double x, y, z, r;
  while (in >> x >> y >> z >> r) balls.push_back({Vec3(x, y, z), r});
  EXPECT_TRUE(in.eof()) << "after " << balls.size() << " lines of x y z r";
  return balls;
}

/// Signed distance of a point to the box [m], negative inside.
double HeightOverBox(const Vec3& p) {
  const Vec3 out = (p - 1e-3 * kMiddle_mm).cwiseAbs() - 0.5e-3 * kSides_mm;
  return out.maxCoeff() < 0.0 ? out.maxCoeff() : out.cwiseMax(0.0).norm();
}

/// Distances from points of a uniform grid on the box's faces to the nearest ball, at least 0 [m].
std::vector<double> BarenessOfBox(const std::vector<Sphere>& balls) {
  std::vector<double> bareness;
  constexpr double kStep = 0.25e-3;
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const double side : {-0.5, 0.5}) {
      for (double a = 0.5 * kStep; a < 1e-3 * kSides_mm[u]; a += kStep) {
        for (double b = 0.5 * kStep; b < 1e-3 * kSides_mm[v]; b += kStep) {
          Vec3 p = 1e-3 * (kMiddle_mm - 0.5 * kSides_mm);
          p[axis] += (side + 0.5) * 1e-3 * kSides_mm[axis];
          p[u] += a;
          p[v] += b;
          double nearest = 1.0;
          for (const Sphere& ball : balls) {
            nearest = std::min(nearest, (p - ball.centre).norm() - ball.radius);
          }
          bareness.push_back(std::max(0.0, nearest));
        }
      }
    }
  }
  return bareness;
}

/// Volume of the union of balls relative to the box's, by a grid of points.
double VolumeRatio(const std::vector<Sphere>& balls) {
  constexpr double kStep = 0.5e-3;
  const Vec3 half = 0.75e-3 * kSides_mm;  // the balls stick out by less than a quarter of a side
  std::size_t within = 0;
  for (double x = -half.x(); x < half.x(); x += kStep) {
    for (double y = -half.y(); y < half.y(); y += kStep) {
      for (double z = -half.z(); z < half.z(); z += kStep) {
        const Vec3 p = 1e-3 * kMiddle_mm + Vec3(x, y, z);
        within += std::ranges::any_of(balls, [&](const Sphere& ball) {
          return (p - ball.centre).squaredNorm() < ball.radius * ball.radius;
        });
      }
    }
  }
  return double(within) * kStep * kStep * kStep / (1e-9 * kSides_mm.prod());
}

double Mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / double(values.size());
}

TEST_F(PalpateBench, TreeMeasuresAMeshAsBruteForceDoesByTheLeavesThatItWrites) {
  WriteBox(File("box.obj"));
  for (const std::string mode : {"inside", "balanced"}) {
    const nlohmann::json json =
        Figures({"tree", "--mesh", File("box.obj"), "--unit", "mm", "--spheres", "64", "--mode",
                 mode, "--samples", "40009", "--out", File("leaves")});
    EXPECT_GT(json.at("build_s"), 0.0);
    const nlohmann::json& levels = json.at("levels");
    ASSERT_EQ(levels.size(), 2u) << "64 leaves in eight packets";
    EXPECT_EQ(levels[0].at("spheres"), 8);
    const nlohmann::json& leaves = levels.back();
    EXPECT_EQ(leaves.at("spheres"), 64);

    const std::vector<Sphere> balls = ReadBalls(File("leaves"));
    ASSERT_EQ(balls.size(), 64u);
    std::vector<double> outside;
    for (const Sphere& ball : balls) {
      outside.push_back(std::max(0.0, ball.radius + HeightOverBox(ball.centre)));
    }
    EXPECT_NEAR(leaves.at("outside_um").at("mean"), 1e6 * Mean(outside), 0.01) << mode;
    EXPECT_NEAR(leaves.at("outside_um").at("max"), 1e6 * *std::ranges::max_element(outside), 0.01);
    EXPECT_LE(leaves.at("outside_um").at("p99"), leaves.at("outside_um").at("max"));
    const std::vector<double> bareness = BarenessOfBox(balls);
    const double mean_um = 1e6 * Mean(bareness);
    EXPECT_NEAR(leaves.at("uncovered_um").at("mean"), mean_um, 0.03 * mean_um + 0.01) << mode;
    EXPECT_NEAR(leaves.at("uncovered_um").at("max"), 1e6 * *std::ranges::max_element(bareness),
                0.05 * 1e6 * *std::ranges::max_element(bareness) + 0.01);
    EXPECT_EQ(leaves.at("outside_um").at("max") > 1.0, mode != "inside");
    EXPECT_LE(leaves.at("signed_offset_um").at("p1"), leaves.at("signed_offset_um").at("mean"));
    EXPECT_LE(leaves.at("signed_offset_um").at("mean"), leaves.at("signed_offset_um").at("p99"));
    EXPECT_LT(leaves.at("normal_deg").at("mean"), leaves.at("normal_deg").at("p99"));
    EXPECT_NEAR(leaves.at("volume_ratio"), VolumeRatio(balls), 0.02) << mode;
    // Bounding balls of other balls err more.
    EXPECT_GT(levels[0].at("outside_um").at("mean"), leaves.at("outside_um").at("mean"));
  }
}

TEST_F(PalpateBench, TreeTakesAMeshAsItIsAndSeveralModesAtOnce) {
  WriteBox(File("box.obj"));
  const nlohmann::json json = Figures({"tree", "--mesh", File("box.obj"), "--spheres", "20",
                                       "--samples", "1009", "--out", File("leaves")});
  EXPECT_EQ(json.at("mode"), "inside");
  EXPECT_THAT(said_, HasSubstr("the leaves are what is felt"));
  for (const Sphere& ball : ReadBalls(File("leaves"))) {
    EXPECT_LE(HeightOverBox(1e-3 * ball.centre) + 1e-3 * ball.radius, 1e-12) << "not in metres";
  }
  const nlohmann::json modes = Figures({"tree", "--mesh", File("box.obj"), "--spheres", "20",
                                        "--samples", "1009", "--modes", "inside,balanced"})
                                   .at("modes");
  ASSERT_EQ(modes.size(), 2u);
  EXPECT_EQ(modes[1].at("mode"), "balanced");
  EXPECT_EQ(modes[1].at("levels").back().at("spheres"), 20);
}

TEST_F(PalpateBench, TreeSaysWhatItLacksAndWhatItCannotWrite) {
  WriteBox(File("box.obj"));
  const std::vector<std::string> tree{"tree", "--mesh", File("box.obj")};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), tree.begin(), tree.end());
    return more;
  };
  EXPECT_EQ(Run(tree), 2);
  EXPECT_THAT(said_, HasSubstr("--spheres is required"));
  EXPECT_EQ(Run(with({"--spheres", "8", "--modes", "inside,balanced", "--out", File("l")})), 2);
  EXPECT_THAT(said_, HasSubstr("give one --mode"));
  EXPECT_EQ(Run(with({"--spheres", "8", "--out", "/nowhere/leaves"})), 1);
  EXPECT_THAT(said_, HasSubstr("--out /nowhere/leaves: cannot be written (No such file"));
  EXPECT_EQ(Run({"tree", "--mesh", File("none.obj"), "--spheres", "8"}), 1);
  EXPECT_THAT(said_, HasSubstr("none.obj"));
}

}  // namespace
}  // namespace palpate
