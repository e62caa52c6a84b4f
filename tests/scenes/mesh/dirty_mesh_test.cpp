// Meshes that are whole files and no clean solids.  Each ends in a right model, told by brute force
// on the clean original, with a remark of what was done; or in a refusal that says what to do.
#include "tests/support/dirty_mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/catalogue.h"
#include "scenes/mesh/mesh_weld.h"
#include "scenes/scene_verdict.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::Both;
using test::ComplaintOf;
using test::FreshFolder;
using test::Random;
using test::WriteFile;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr std::size_t kLeaves = 300;

/// A ball with bumps on it, of 40 mm and some 1,300 triangles.
TriangleMesh Bumpy() {
  TriangleMesh mesh = MakeSphere(0.02, 1280);
  for (Vec3& v : mesh.vertices) {
    const Vec3 u = v / 0.02;
    v *= 1.0 + 0.1 * std::sin(7.0 * u.x()) * std::cos(5.0 * u.y() + 3.0 * u.z());
  }
  return mesh;
}

/// The scene of a mesh that is felt by its spheres, as a file of metres would make it.
Scene Felt(const TriangleMesh& mesh, const std::string& more = "") {
  const std::string folder = FreshFolder();
  WriteFile(folder + "/mesh.obj", test::ObjOf(mesh));
  const std::string scene = WriteFile(
      folder + "/scene.json",
      R"({"contact":"spheres","tools":[{"name":"ball","mesh":{"shape":"sphere","radius_m":0.002},
"leaves":1}],"objects":[{"name":"object","leaves":)" +
          std::to_string(kLeaves) + R"(,"mesh":{"file":"mesh.obj","unit":"m","origin":"file")" +
          more + "}}]}");
  LoadOptions options;
  options.use_cache = false;
  return LoadScene(scene, options);
}

Sphere Leaf(const SphereTree& tree, std::size_t i) {
  return {{tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]}, tree.leaf_radius[i]};
}

/// The most that any leaf sticks out of a clean mesh; every leaf is a ball.
double MostOutside(const Scene& scene, const TriangleMesh& clean) {
  const SphereTree& tree = scene.objects[0].tree;
  EXPECT_EQ(tree.leaves(), kLeaves);
  double most = 0.0;
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    EXPECT_GT(tree.leaf_radius[i], 0.0);
    most = std::max(most, test::SticksOut(clean, Leaf(tree, i)));
  }
  return most;
}

/// How far the surface lies from the nearest leaf, where it does most: told at triangles' middles.
double MostBare(const Scene& scene, const TriangleMesh& clean) {
  const SphereTree& tree = scene.objects[0].tree;
  double most = 0.0;
  for (std::size_t t = 0; t < clean.triangles.size(); ++t) {
    const Vec3 p =
        (test::Corner(clean, t, 0) + test::Corner(clean, t, 1) + test::Corner(clean, t, 2)) / 3.0;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      const Sphere leaf = Leaf(tree, i);
      nearest = std::min(nearest, (p - leaf.centre).norm() - leaf.radius);
    }
    most = std::max(most, nearest);
  }
  return most;
}

std::string Verdict(const Scene& scene) {
  return ToText(JudgeScene(scene));
}

TEST(DirtyMesh, SoupOfJitteredCornersAndTurnedFacesIsWeldedAndOriented) {
  Random random(1);
  const TriangleMesh clean = Bumpy();
  TriangleMesh soup = test::Unwelded(clean, 1e-6 * 0.04, random);
  test::TurnSome(soup, 0.05, random);
  const Scene scene = Felt(soup);
  EXPECT_LT(MostOutside(scene, clean), 1e-6);  // what the jitter moves a surface by, and its slope
  EXPECT_LT(MostBare(scene, clean), 1e-3);
  EXPECT_TRUE(InspectMesh(scene.objects[0].mesh).solid());
  EXPECT_THAT(Verdict(scene), AllOf(HasSubstr("usable with these limits"),
                                    HasSubstr("welded within"), HasSubstr("they are turned")));
}

TEST(DirtyMesh, ScrapsTooSmallToCountAreNotWelded) {
  // Edges of 1e-21 m in a mesh of a metre: cells of a twentieth of that have no numbers.
  Random random(4);
  TriangleMesh mesh = test::Unwelded(Bumpy(), 1e-6 * 0.04, random);
  for (Vec3& v : mesh.vertices) v *= 1e-18;
  TriangleMesh alone = mesh;
  EXPECT_GT(WeldOpenEdges(alone).vertices, 0u);
  mesh.vertices.push_back(Vec3::Ones());
  mesh.triangles.push_back({0, 1, static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  EXPECT_EQ(WeldOpenEdges(mesh).vertices, 0u);
}

TEST(DirtyMesh, SoupThatCannotBeWeldedIsOrientedByWhatWindsRoundIt) {
  Random random(2);
  const TriangleMesh clean = Bumpy();
  TriangleMesh soup = test::Unwelded(clean, 1e-3 * 0.04, random);
  test::TurnSome(soup, 0.05, random);
  const Scene scene = Felt(soup);
  EXPECT_LT(MostOutside(scene, clean), 1e-3 * 0.04 * 4);  // a corner moves by sqrt(3) of it
  EXPECT_LT(MostBare(scene, clean), 1e-3);
  EXPECT_THAT(Verdict(scene), AllOf(HasSubstr("edges are open"), HasSubstr("are turned")));
}

TEST(DirtyMesh, OneOfTwoPiecesThatIsInsideOutIsTurned) {
  const TriangleMesh clean = Both(Bumpy(), test::Moved(Bumpy(), Vec3(0.05, 0, 0)));
  const Scene scene = Felt(Both(Bumpy(), test::TurnedOver(test::Moved(Bumpy(), Vec3(0.05, 0, 0)))));
  EXPECT_LT(MostOutside(scene, clean), 1e-8);  // floats of the file
  EXPECT_LT(MostBare(scene, clean), 2e-3);
  EXPECT_THAT(Verdict(scene), HasSubstr("inside out"));
}

TEST(DirtyMesh, OpenShellThatIsInsideOutIsTurned) {
  const TriangleMesh clean = Bumpy();
  const TriangleMesh holed = test::Without(clean, [](const Vec3& p) { return p.y() > 0.0195; });
  ASSERT_LT(holed.triangles.size(), clean.triangles.size());
  const Scene scene = Felt(test::TurnedOver(holed));
  EXPECT_LT(MostOutside(scene, clean), 2e-4);
  EXPECT_THAT(Verdict(scene), AllOf(HasSubstr("edges are open"), HasSubstr("inside out")));
}

TEST(DirtyMesh, ShellWithAnOpenFloorIsFilledAsIfALidClosedIt) {
  const Vec3 size(0.06, 0.02, 0.03);
  const TriangleMesh body =
      test::Without(MakeBox(size), [](const Vec3& p) { return p.y() < -0.0099; });
  ASSERT_EQ(body.triangles.size(), 10u);
  const Scene scene = Felt(body);
  EXPECT_LT(MostOutside(scene, MakeBox(size)), 1e-9);
  EXPECT_LT(MostBare(scene, body), 2e-3);
  EXPECT_EQ(scene.objects[0].mesh.triangles.size(), 10u) << "what is drawn stays as it is";
  EXPECT_THAT(Verdict(scene), AllOf(HasSubstr("flat lid"), HasSubstr("67.1 mm wide")));
}

TEST(DirtyMesh, SheetHasAPlateBehindItOfAStatedThickness) {
  const TriangleMesh sheet = test::MakeSheet(0.025, 12, [](double x, double z) {
    return 0.003 * std::sin(200.0 * x) * std::cos(150.0 * z);
  });
  const Scene scene = Felt(sheet);
  const double diagonal = std::hypot(0.05, 0.05, 0.006);
  for (std::size_t i = 0; i < kLeaves; ++i) {
    const Sphere leaf = Leaf(scene.objects[0].tree, i);
    EXPECT_GT(leaf.radius, 0.0);
    double nearest = 1.0;
    for (std::size_t t = 0; t < sheet.triangles.size(); ++t) {
      nearest = std::min(nearest,
                         (NearestOnTriangle(leaf.centre, test::Corner(sheet, t, 0),
                                            test::Corner(sheet, t, 1), test::Corner(sheet, t, 2)) -
                          leaf.centre)
                             .norm());
    }
    EXPECT_LT(nearest + leaf.radius, 0.025 * diagonal);
    EXPECT_GT(nearest, 0.99 * leaf.radius) << "none stands in front of it";
  }
  EXPECT_EQ(scene.objects[0].mesh.triangles.size(), sheet.triangles.size());
  EXPECT_THAT(Verdict(scene), AllOf(HasSubstr("is a sheet"), HasSubstr("1.42 mm thick"),
                                    HasSubstr("\"thickness_mm\"")));
}

TEST(DirtyMesh, SheetThatIsGivenAThicknessIsAPlateToSeeAndToTouch) {
  const TriangleMesh sheet = test::MakeSheet(0.025, 4, [](double, double) { return 0.0; });
  const Scene scene = Felt(sheet, R"(,"thickness_mm":3)");
  const MeshReport report = InspectMesh(scene.objects[0].mesh);
  EXPECT_TRUE(report.solid());
  EXPECT_NEAR(report.volume, 0.05 * 0.05 * 0.003, 1e-12);
  EXPECT_NEAR(report.box_min.y(), -0.003, 1e-15);
  EXPECT_NEAR(report.box_max.y(), 0.0, 1e-15);
  EXPECT_LT(MostOutside(scene, scene.objects[0].mesh), 1e-9);
}

TEST(DirtyMesh, TwoFacesBackToBackAreRefusedOrGivenAThickness) {
  TriangleMesh sheet = test::MakeSheet(0.025, 4, [](double, double) { return 0.0; });
  const auto faces = sheet.triangles;
  for (const auto& [i, j, k] : faces) sheet.triangles.push_back({i, k, j});
  EXPECT_THAT(ComplaintOf([&] { Felt(sheet); }),
              AllOf(HasSubstr("encloses nothing"), HasSubstr("\"thickness_mm\"")));
  const Scene scene = Felt(sheet, R"(,"thickness_mm":3)");
  EXPECT_NEAR(InspectMesh(scene.objects[0].mesh).volume, 0.05 * 0.05 * 0.003, 1e-12);
  EXPECT_LT(MostOutside(scene, scene.objects[0].mesh), 1e-9);
}

TEST(DirtyMesh, ThicknessOfAClosedMeshIsRefused) {
  EXPECT_THAT(ComplaintOf([&] { Felt(Bumpy(), R"(,"thickness_mm":3)"); }),
              AllOf(HasSubstr("thickness_mm"), HasSubstr("closed"), HasSubstr("drop it")));
}

}  // namespace
}  // namespace palpate
