// Meshes in valid files that are not clean solids.  Each becomes a correct model, judged by brute
// force against the clean original, with a remark of what was done; or is refused with a remedy.
#include "tests/support/dirty_mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/catalogue.h"
#include "scenes/mesh/mesh_import.h"
#include "scenes/mesh/mesh_mend.h"
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

/// A bumpy ball of 40 mm with some 1,300 triangles.
TriangleMesh Bumpy(int triangles = 1280) {
  TriangleMesh mesh = MakeSphere(0.02, triangles);
  for (Vec3& v : mesh.vertices) {
    const Vec3 u = v / 0.02;
    v *= 1.0 + 0.1 * std::sin(7.0 * u.x()) * std::cos(5.0 * u.y() + 3.0 * u.z());
  }
  return mesh;
}

/// The same with triangles of 4 mm, where many copies are needed.
constexpr int kCoarse = 320;

TriangleMesh Scaled(TriangleMesh mesh, double by) {
  for (Vec3& v : mesh.vertices) v *= by;
  return mesh;
}

/// The scene of a mesh felt through its spheres, as from a file in metres.  The spheres are built
/// inside, so anything that sticks out is a fault.
Scene Felt(const TriangleMesh& mesh, const std::string& more = "") {
  const std::string folder = FreshFolder();
  WriteFile(folder + "/mesh.obj", test::ObjOf(mesh));
  const std::string scene = WriteFile(
      folder + "/scene.json",
      R"({"contact":"spheres","tools":[{"name":"ball","mesh":{"shape":"sphere","radius_m":0.002},
"leaves":1}],"objects":[{"name":"object","tree":"inside","leaves":)" +
          std::to_string(kLeaves) + R"(,"mesh":{"file":"mesh.obj","unit":"m","origin":"file")" +
          more + "}}]}");
  LoadOptions options;
  options.use_cache = false;
  return LoadScene(scene, options);
}

Sphere Leaf(const SphereTree& tree, std::size_t i) {
  return {{tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]}, tree.leaf_radius[i]};
}

/// The largest protrusion of any leaf from a clean mesh; every leaf must be a ball.
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

/// The number of leaves partly outside a closed mesh, which may intersect itself.
int LeavesOutside(const Scene& scene, const TriangleMesh& mesh) {
  int outside = 0;
  for (std::size_t i = 0; i < kLeaves; ++i) {
    outside += test::AnyPlaceOutside(mesh, Leaf(scene.objects[0].tree, i));
  }
  return outside;
}

/// The largest distance from the surface to its nearest leaf, at the triangles' centroids.
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

/// Expects a dirty mesh to feel like the clean one: leaves stick out by less than `outside` and
/// leave less than `bare` uncovered, and the verdict says what was done.
Scene ExpectFelt(const TriangleMesh& dirty, const TriangleMesh& clean, double outside, double bare,
                 const testing::Matcher<std::string>& verdict) {
  const Scene scene = Felt(dirty);
  EXPECT_LT(MostOutside(scene, clean), outside);
  EXPECT_LT(MostBare(scene, clean), bare);
  EXPECT_THAT(Verdict(scene), verdict);
  return scene;
}

constexpr double kFloats = 1e-8;  // precision of the file

TEST(DirtyMesh, SoupOfJitteredCornersAndTurnedFacesIsWeldedAndOriented) {
  Random random(1);
  const TriangleMesh clean = Bumpy();
  TriangleMesh soup = test::Unwelded(clean, 1e-6 * 0.04, random);
  test::TurnSome(soup, 0.05, random);
  // 1 um allows for the jitter's shift of a surface, and its slope.
  const Scene scene = ExpectFelt(soup, clean, 1e-6, 1e-3,
                                 AllOf(HasSubstr("usable with these limits"),
                                       HasSubstr("welded within"), HasSubstr("they are turned")));
  EXPECT_TRUE(InspectMesh(scene.objects[0].mesh).solid());
}

TEST(DirtyMesh, ScrapsTooSmallToCountAreNotWelded) {
  // Edges of 1e-21 m in a mesh of a metre: cells of a twentieth of that could not be numbered.
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
  // A vertex moves by sqrt(3) of the jitter.
  ExpectFelt(soup, clean, 1e-3 * 0.04 * 4, 1e-3,
             AllOf(HasSubstr("edges are open"), HasSubstr("are turned")));
}

TEST(DirtyMesh, OneOfTwoPiecesThatIsInsideOutIsTurned) {
  const TriangleMesh clean = Both(Bumpy(), test::Moved(Bumpy(), Vec3(0.05, 0, 0)));
  ExpectFelt(Both(Bumpy(), test::TurnedOver(test::Moved(Bumpy(), Vec3(0.05, 0, 0)))), clean,
             kFloats, 2e-3, HasSubstr("inside out"));
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
  EXPECT_THAT(
      ComplaintOf([&] { Felt(sheet); }),
      AllOf(HasSubstr("object: "), HasSubstr("encloses no volume"), HasSubstr("\"thickness_mm\"")));
  const Scene scene = Felt(sheet, R"(,"thickness_mm":3)");
  EXPECT_NEAR(InspectMesh(scene.objects[0].mesh).volume, 0.05 * 0.05 * 0.003, 1e-12);
  EXPECT_LT(MostOutside(scene, scene.objects[0].mesh), 1e-9);
}

TEST(DirtyMesh, ShellOfThinWallsIsAnObject) {
  for (const double wall : {30e-6, 100e-6}) {
    TriangleMesh shell = MakeSphere(0.015, 320);
    const TriangleMesh inner = MakeSphere(0.015 - wall, 320);
    const auto first = static_cast<std::uint32_t>(shell.vertices.size());
    shell.vertices.insert(shell.vertices.end(), inner.vertices.begin(), inner.vertices.end());
    for (const auto& [i, j, k] : inner.triangles) {
      shell.triangles.push_back({first + i, first + k, first + j});
    }
    const Scene scene = Felt(shell);
    EXPECT_NEAR(InspectMesh(scene.objects[0].mesh).volume, 4 * M_PI * 0.015 * 0.015 * wall,
                0.1 * 4 * M_PI * 0.015 * 0.015 * wall);
    for (std::size_t i = 0; i < kLeaves; ++i) {
      const Sphere leaf = Leaf(scene.objects[0].tree, i);
      EXPECT_GT(leaf.radius, 0.0);
      EXPECT_LE(leaf.radius, 0.51 * wall);
      EXPECT_LT(std::abs(leaf.centre.norm() - 0.015), 0.05 * 0.015);
    }
  }
}

TEST(DirtyMesh, ThicknessOfAClosedMeshIsRefused) {
  EXPECT_THAT(ComplaintOf([&] { Felt(Bumpy(), R"(,"thickness_mm":3)"); }),
              AllOf(HasSubstr("thickness_mm"), HasSubstr("closed"), HasSubstr("drop it")));
}

// The reference for what follows: as many leaves leave at most 0.4 mm of the clean original bare.
constexpr double kCleanBare = 5e-4;

TEST(DirtyMesh, ShellsThatPassThroughEachOtherAreOneSolidAndSoWhereOneIsInsideOut) {
  const TriangleMesh one = MakeSphere(0.02, kCoarse);
  const TriangleMesh other = test::Moved(one, Vec3(0.0213, 0.0011, 0.0007));
  const TriangleMesh both = Both(one, other), exposed = test::Exposed(both);
  ASSERT_LT(exposed.triangles.size(), both.triangles.size() * 9 / 10);
  for (const TriangleMesh& dirty : {both, Both(one, test::TurnedOver(other))}) {
    const Scene scene = Felt(dirty);
    EXPECT_EQ(LeavesOutside(scene, both), 0);
    EXPECT_LT(MostBare(scene, exposed), 0.01 * 0.06);  // of the longest side
    EXPECT_THAT(Verdict(scene), AllOf(HasSubstr("usable"), HasSubstr("parts overlap")));
  }
}

TEST(DirtyMesh, ShellWithASecondOneUnderItIsFilledPastThat) {
  const TriangleMesh clean = Bumpy();
  ExpectFelt(Both(clean, Scaled(clean, 0.98)), clean, kFloats, kCleanBare,
             HasSubstr("parts overlap: 49 %"));
}

/// A box from x_low to x_high; two such boxes side by side share vertices once they are read.
TriangleMesh BoxBetween(double x_low, double x_high) {
  TriangleMesh box = MakeBox(Vec3(x_high - x_low, 0.04, 0.04));
  for (Vec3& v : box.vertices) v.x() += 0.5 * (x_low + x_high);
  return box;
}

TEST(DirtyMesh, WallAcrossTheInsideAndTwoBodiesFaceToFaceAreOneSolid) {
  const TriangleMesh left = BoxBetween(-0.03, 0.0), right = BoxBetween(0.0, 0.03);
  const TriangleMesh two = Both(left, right);
  const TriangleMesh outside =
      test::Without(two, [](const Vec3& p) { return std::abs(p.x()) < 1e-6; });
  ASSERT_EQ(outside.triangles.size(), 20u);
  const TriangleMesh wall = test::Without(left, [](const Vec3& p) { return p.x() < -1e-6; });
  const TriangleMesh clean = BoxBetween(-0.03, 0.03);
  const double as_clean = MostBare(Felt(outside), outside);
  for (const TriangleMesh& dirty : {two, Both(outside, wall)}) {
    const Scene scene = Felt(dirty);
    EXPECT_LT(MostOutside(scene, clean), 1e-8);
    EXPECT_LE(MostBare(scene, outside), as_clean + 1e-6);
    EXPECT_THAT(Verdict(scene),
                AllOf(HasSubstr("more than two triangles"), HasSubstr("parts overlap")));
  }
}

TEST(DirtyMesh, BodyWithBothSidesOfSomeOrAllFacesHasOne) {
  const TriangleMesh clean = Bumpy();
  for (const std::size_t twice : {std::size_t{200}, clean.triangles.size()}) {
    TriangleMesh dirty = clean;
    for (std::size_t t = 0; t < twice; ++t) {
      const auto [i, j, k] = clean.triangles[t];
      dirty.triangles.push_back({i, k, j});
    }
    const Scene scene =
        ExpectFelt(dirty, clean, kFloats, kCleanBare, HasSubstr("stood there twice"));
    EXPECT_EQ(scene.objects[0].mesh.triangles.size(), clean.triangles.size());
  }
}

TEST(DirtyMesh, FinOnABodyIsAPlateAndTheBodyIsFilled) {
  const TriangleMesh clean = Bumpy();
  TriangleMesh dirty = clean;
  const auto [i, j, k] = clean.triangles[100];
  const auto first = static_cast<std::uint32_t>(clean.vertices.size());
  dirty.vertices.push_back(1.25 * clean.vertices[i]);
  dirty.vertices.push_back(1.25 * clean.vertices[j]);
  dirty.triangles.push_back({i, j, first});
  dirty.triangles.push_back({j, first + 1, first});
  const Scene scene = Felt(dirty);
  const double thickness = 0.02 * std::hypot(0.045, 0.045, 0.045);
  for (std::size_t n = 0; n < kLeaves; ++n) {
    const Sphere leaf = Leaf(scene.objects[0].tree, n);
    if (test::SticksOut(clean, leaf) < 1e-8) continue;
    double from_fin = 1.0;
    for (std::size_t t = clean.triangles.size(); t < dirty.triangles.size(); ++t) {
      const Vec3 q = NearestOnTriangle(leaf.centre, test::Corner(dirty, t, 0),
                                       test::Corner(dirty, t, 1), test::Corner(dirty, t, 2));
      from_fin = std::min(from_fin, (q - leaf.centre).norm());
    }
    EXPECT_LT(from_fin + leaf.radius, 1.1 * thickness);
  }
  EXPECT_LT(MostBare(scene, clean), 1.2 * kCleanBare);  // some leaves belong to the plate
  EXPECT_THAT(Verdict(scene), AllOf(HasSubstr("more than two triangles"), HasSubstr("sheet")));
}

TEST(DirtyMesh, FinInsideABodyIsPassedOver) {
  const TriangleMesh clean = Bumpy();
  TriangleMesh dirty = clean;
  const auto [i, j, k] = clean.triangles[100];
  dirty.vertices.push_back(0.7 * clean.vertices[i]);
  dirty.triangles.push_back({i, j, static_cast<std::uint32_t>(clean.vertices.size())});
  ExpectFelt(dirty, clean, kFloats, kCleanBare,
             AllOf(HasSubstr("more than two triangles"), Not(HasSubstr("lid"))));
}

TEST(DirtyMesh, SurfaceThatFoldsIntoItselfIsFilledPastTheFold) {
  // A roll whose ends intersect.
  TriangleMesh roll = test::TurnedOver(MakeSphere(0.01, kCoarse));
  for (Vec3& v : roll.vertices) {
    const double along = 335.0 * v.x(), out = 0.02 + v.y();
    v = Vec3(out * std::cos(along), out * std::sin(along), v.z());
  }
  ASSERT_GT(InspectMesh(roll).volume, 0.0);
  const TriangleMesh exposed = test::Exposed(roll);
  ASSERT_LT(exposed.triangles.size(), roll.triangles.size());
  const Scene scene = Felt(roll);
  EXPECT_EQ(LeavesOutside(scene, roll), 0);
  EXPECT_LT(MostBare(scene, exposed), 2e-3);
  EXPECT_THAT(Verdict(scene), AllOf(HasSubstr("usable"), HasSubstr("parts overlap")));
}

TEST(DirtyMesh, VertexFarOutIsNamedAndRefusedWhereItIsAMistakeForCertain) {
  TriangleMesh dirty = Bumpy();
  dirty.vertices[40] *= 5.0;
  EXPECT_THAT(Verdict(Felt(dirty)), AllOf(HasSubstr("a vertex is far from all others"),
                                          HasSubstr("in place of 0.1"), HasSubstr("delete it")));
  TriangleMesh cube = MakeBox(Vec3::Constant(1e-3));
  cube.vertices[0] = Vec3(100, 0, 0);
  EXPECT_THAT(ComplaintOf([&] { Felt(cube); }),
              AllOf(HasSubstr("mesh.obj"), HasSubstr("at (100, 0, 0)"), HasSubstr("delete it")));
  EXPECT_THAT(Verdict(Felt(MakeBox(Vec3(0.1, 0.002, 0.002)))), Not(HasSubstr("far out")));
}

/// A jaw scan: no floor, and a wavy rim.
TriangleMesh Jaw() {
  return test::Without(Bumpy(), [](const Vec3& p) {
    return p.y() < -0.004 + 0.003 * std::sin(6.0 * std::atan2(p.z(), p.x()));
  });
}

TEST(DirtyMesh, OpenScanWithCrumbsInTheAirIsFilledAndTheyAreLeftOut) {
  Random random(5);
  TriangleMesh dirty = Jaw(), beads = Jaw();
  for (int n = 0; n < 30; ++n) {
    const Vec3 at = random.InCube(0.01) + Vec3(0.0, 0.035, 0.0);
    dirty =
        Both(dirty, test::Moved(test::MakeSheet(3e-4, 2, [](double x, double) { return x; }), at));
    beads = Both(beads, test::Moved(MakeSphere(2e-4, 20), at));
  }
  const Scene scene = Felt(dirty);
  EXPECT_EQ(scene.objects[0].mesh.triangles.size(), Jaw().triangles.size());
  EXPECT_EQ(InspectMesh(scene.objects[0].mesh).unused_vertices, 0u);
  EXPECT_LT(MostOutside(scene, Bumpy()), 1e-8);
  EXPECT_THAT(Verdict(scene), AllOf(HasSubstr("30 small pieces float apart"), HasSubstr("left out"),
                                    HasSubstr("flat lid")));
  // Closed pieces may be intended.
  const Scene with_beads = Felt(beads);
  EXPECT_EQ(with_beads.objects[0].mesh.triangles.size(), beads.triangles.size());
  EXPECT_THAT(Verdict(with_beads), AllOf(HasSubstr("30 small pieces"), HasSubstr("are felt")));
}

TEST(DirtyMesh, SpeckOfDustFarOffDoesNotMakeTheBodySmall) {
  const TriangleMesh clean = Bumpy();
  TriangleMesh speck = MakeSphere(1e-6, 20);
  speck.triangles.resize(4);
  const Scene scene = ExpectFelt(Both(clean, test::Moved(speck, Vec3(0.05, 0, 0))), clean, kFloats,
                                 kCleanBare, HasSubstr("a small piece floats apart"));
  EXPECT_LT(InspectMesh(scene.objects[0].mesh).box_max.x(), 0.025);
}

TEST(DirtyMesh, PartsKeepTheirTrianglesWhereOthersAreLeftOut) {
  const TriangleMesh crumb =
      test::Moved(test::MakeSheet(3e-4, 2, [](double, double) { return 0.0; }), Vec3(0, 0.04, 0));
  TriangleMesh mesh = Both(crumb, Bumpy());
  const auto all = static_cast<std::uint32_t>(mesh.triangles.size());
  std::vector<MeshGroup> groups{{"crumb", 0, 8}, {"body", 8, all}, {"end", all - 3, all}};
  MendMesh(mesh, &groups);
  ASSERT_EQ(mesh.triangles.size(), all - 8);
  EXPECT_EQ(groups[0].begin, groups[0].end);
  EXPECT_EQ(groups[1].begin, 0u);
  EXPECT_EQ(groups[1].end, all - 8);
  EXPECT_EQ(groups[2].begin, all - 8 - 3);
}

TEST(DirtyMesh, SizeThatNoHandFeelsIsSaidWithTheLikelyUnit) {
  const auto remark = [](double metres, double metres_per_unit) {
    MeshPlacement placement;
    placement.metres_per_unit = metres_per_unit;
    return UnitRemark(placement, MakeBox(Vec3(0.5, 1.0, 0.5) * metres));
  };
  EXPECT_THAT(remark(42.0, 1.0),
              AllOf(HasSubstr("in m its longest side is 4.2e+04 mm"),
                    HasSubstr("means mm, which makes it 42 mm"), HasSubstr("\"unit\": \"mm\"")));
  EXPECT_THAT(remark(1000.0, 1.0), HasSubstr("means mm"));
  EXPECT_THAT(remark(4e-5, 1e-3), HasSubstr("means m, which makes it 40 mm"));
  EXPECT_THAT(remark(1e-9, 1.0), AllOf(HasSubstr("no other unit"), HasSubstr("longest_side_m")));
  EXPECT_EQ(remark(0.04, 1.0), "");
  MeshPlacement given;
  given.longest_side = 1000.0;
  EXPECT_EQ(UnitRemark(given, MakeBox(Vec3::Constant(1000.0))), "");
}

TEST(DirtyMesh, BodyOfANanometreIsFilledAndSaid) {
  const TriangleMesh clean = Scaled(Bumpy(kCoarse), 2.5e-8);
  const Scene scene = Felt(clean);
  EXPECT_LT(MostOutside(scene, clean), 1e-16);
  EXPECT_THAT(Verdict(scene), HasSubstr("longest_side_m"));
}

TEST(DirtyMesh, TwoScansWithACrackBetweenThemAreOneSolidAndSoWhereOneIsInsideOut) {
  const auto below = [](const Vec3& p) { return p.y() < 0.0; };
  const TriangleMesh upper = test::Moved(test::Without(Bumpy(), below), Vec3(0, 1e-4, 0));
  const TriangleMesh lower = test::Without(Bumpy(), std::not_fn(below));
  for (const TriangleMesh& dirty : {Both(upper, lower), Both(upper, test::TurnedOver(lower))}) {
    // The upper half is raised by 0.1 mm.
    ExpectFelt(dirty, Bumpy(), 1.01e-4, kCleanBare + 1e-4,
               AllOf(HasSubstr("edges are open"), Not(HasSubstr("sheet"))));
  }
}

TEST(DirtyMesh, ChainsOfTJunctionsAreNoWideOpening) {
  Random random(9);
  const TriangleMesh clean = Bumpy(kCoarse);
  TriangleMesh dirty;
  dirty.vertices = clean.vertices;
  for (const auto& [i, j, k] : clean.triangles) {
    const double s = random.Uniform(0.1, 0.9);
    const auto middle = static_cast<std::uint32_t>(dirty.vertices.size());
    dirty.vertices.push_back((1.0 - s) * clean.vertices[i] + s * clean.vertices[j]);
    dirty.triangles.push_back({i, middle, k});
    dirty.triangles.push_back({middle, j, k});
  }
  ExpectFelt(dirty, clean, kFloats, 1.2 * MostBare(Felt(clean), clean),
             HasSubstr("edges are open"));
}

TEST(DirtyMesh, ManyHolesTooSmallForALidLetNoSphereOut) {
  const TriangleMesh clean = MakeSphere(0.02, 5120);
  TriangleMesh dirty = clean;
  std::size_t n = 0;
  std::erase_if(dirty.triangles, [&](const auto&) { return n++ % 97 == 0; });
  const Scene scene = Felt(dirty);
  EXPECT_LT(MostOutside(scene, clean), 1e-5);  // through holes 1.3 mm wide
  EXPECT_LT(MostBare(scene, dirty), 1e-4);
  EXPECT_THAT(Verdict(scene), AllOf(HasSubstr("edges are open"), Not(HasSubstr("lid"))));
}

TEST(DirtyMesh, VerticesOfNoTriangleFarAwayDoNotCount) {
  TriangleMesh dirty = Bumpy();
  dirty.vertices.push_back(Vec3::Constant(100.0));
  const Scene scene = Felt(dirty);
  EXPECT_LT(InspectMesh(scene.objects[0].mesh).box_max.maxCoeff(), 0.025);
  EXPECT_LT(MostOutside(scene, scene.objects[0].mesh), 1e-8);
  EXPECT_THAT(Verdict(scene), HasSubstr("good to touch"));
}

}  // namespace
}  // namespace palpate
