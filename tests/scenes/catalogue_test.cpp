#include "scenes/catalogue.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/json/pose_script.h"
#include "scenes/files/scene_bundle.h"
#include "scenes/files/scene_file.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/scene_verdict.h"
#include "tests/scenes/support.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using test::ComplaintOf;
using test::FreshFolder;
using test::WriteFile;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;

/// Sets an environment variable for its own lifetime.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    setenv(name, value.c_str(), 1);
  }
  ~Environment() { old_.empty() ? unsetenv(name_) : setenv(name_, old_.c_str(), 1); }

 private:
  const char* name_;
  std::string old_;
};

std::string SceneText(int leaves) {
  return R"({"tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1}],
  "objects": [{"name": "box", "mesh": {"file": "box.obj", "unit": "mm"},
               "leaves": )" +
         std::to_string(leaves) + "}]}";
}

constexpr char kTetrahedron[] =
    "v 0 0 0\nv 10 0 0\nv 0 10 0\nv 0 0 10\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

/// A scene in its own folder, loaded with its own cache.
class LoadedScene : public testing::Test {
 protected:
  LoadedScene() {
    WriteFile(scene_, SceneText(20));
    WriteFile(folder_ + "/box.obj", kTetrahedron);
    options_.cache_dir = folder_ + "/cache";
    options_.warn = [this](const std::string& text) { warnings_.push_back(text); };
    options_.tell = [this](const std::string& text) { told_.push_back(text); };
    options_.progress = [this](std::string_view, double) { built_ = true; };
  }
  Scene Load() {
    built_ = false;
    return LoadScene(scene_, options_);
  }
  Scene Load(const std::string& text) {
    WriteFile(scene_, text);
    return Load();
  }
  std::string Complaint() {
    return ComplaintOf([this] { Load(); });
  }
  std::vector<std::string> Cached() const {
    std::vector<std::string> files;
    for (const auto& entry : fs::directory_iterator(options_.cache_dir)) {
      files.push_back(entry.path().string());
    }
    return files;
  }
  std::string folder_ = FreshFolder(), scene_ = folder_ + "/s.json";
  LoadOptions options_;
  std::vector<std::string> warnings_, told_;
  bool built_ = false;
};

TEST(Catalogue, HoldsTheScenesThatTheProjectPromises) {
  EXPECT_THAT(CatalogueNames(),
              IsSupersetOf({"cube", "ellipsoid", "bunny-bunny", "bunny-bunny-22k", "dragon-buddha",
                            "dragon-dragon", "periodontal", "oral-cavity", "jaw", "pipes",
                            "friction", "calculus", "caries", "crown", "osteotomy", "mould"}));
  for (const std::string& name : CatalogueNames()) {
    const std::string file = FindSceneFile(name);
    const SceneDescription scene = ParseScene(ReadWholeFile(file), file);
    EXPECT_EQ(scene.name, name);
    EXPECT_EQ(scene.coupling.stiffness, 1000.0);
    EXPECT_EQ(scene.coupling.torsional_stiffness, 1.0);
  }
}

TEST(Catalogue, CubeAndEllipsoidAreThoseOfTheAccuracyExperiment) {
  LoadOptions options;
  options.use_cache = false;
  options.tree = TreeMode::kInside;  // the fastest to build: only the meshes are examined
  const Scene cube = LoadScene("cube", options);
  ASSERT_EQ(cube.tools[0].tree.leaves(), 1u);
  EXPECT_EQ(cube.tools[0].tree.leaf_radius[0], 0.005);
  const MeshReport box = InspectMesh(cube.objects[0].mesh);
  EXPECT_NEAR((box.box_max - Vec3::Constant(0.025)).norm(), 0.0, 1e-15);
  const Scene ellipsoid = LoadScene("ellipsoid", options);
  const Vec3 axes(0.04, 0.025, 0.03);
  EXPECT_GT(ellipsoid.objects[0].mesh.triangles.size(), 50'000u);
  for (const auto& [i, j, k] : ellipsoid.objects[0].mesh.triangles) {
    const auto& v = ellipsoid.objects[0].mesh.vertices;
    for (const Vec3& p : {v[i], v[j], v[k], Vec3((v[i] + v[j] + v[k]) / 3.0)}) {
      const Vec3 gradient = p.cwiseQuotient(axes.cwiseProduct(axes));
      EXPECT_LT(std::abs(p.cwiseQuotient(axes).norm() - 1.0), 3.1e-6 * gradient.norm());
    }
  }
}

TEST(Catalogue, BunnyIsScaledAndCentredAsPromised) {
  if (!fs::exists("/usr/share/glmark2/models/bunny.obj")) {
    GTEST_SKIP() << "the bunny is missing: install glmark2-data";
  }
  const std::string folder = FreshFolder();
  WriteFile(folder + "/b.json", R"({
    "tools": [{"name": "b", "mesh": {"model": "bunny", "longest_side_m": 0.15}, "leaves": 64}],
    "objects": [{"name": "c", "mesh": {"model": "bunny", "longest_side_m": 0.15}, "leaves": 64}]})");
  LoadOptions options;
  options.use_cache = false;
  const Scene scene = LoadScene(folder + "/b.json", options);
  const MeshReport r = InspectMesh(scene.objects[0].mesh);
  EXPECT_NEAR((r.box_max - r.box_min).maxCoeff(), 0.15, 1e-12);
  EXPECT_NEAR((r.box_max + r.box_min).norm(), 0.0, 1e-12);
  EXPECT_TRUE(r.solid());
  EXPECT_EQ(scene.objects[0].X_WB.p, Vec3(0, 0, 0));
  EXPECT_EQ(scene.tools[0].tree.leaf_x, scene.objects[0].tree.leaf_x);
}

TEST_F(LoadedScene, BuildsOnceAndThenReadsTheSameFromTheCache) {
  const Scene first = Load();
  EXPECT_TRUE(built_);
  const Scene second = Load();
  EXPECT_FALSE(built_);
  EXPECT_EQ(PackScene(first), PackScene(second));
  EXPECT_EQ(first.objects[0].tree.leaves(), 20u);
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(LoadedScene, BuildsAnewWhenTheSceneOrAMeshChanges) {
  Load();
  WriteFile(scene_, SceneText(21));
  EXPECT_EQ(Load().objects[0].tree.leaves(), 21u);
  EXPECT_TRUE(built_);
  std::string mesh = kTetrahedron;
  mesh[2] = '1';
  WriteFile(folder_ + "/box.obj", mesh);
  Load();
  EXPECT_TRUE(built_);
  EXPECT_EQ(Cached().size(), 3u);
}

/// A sphere of 80 triangles from a file with two parts, and a ball.
std::string CurvedText(const std::string& curved) {
  return R"({"tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1}],
  "objects": [{"name": "ball2", "mesh": {"file": "ball.obj", "unit": "m")" +
         curved + R"(}, "leaves": 64, "regions": [
    {"group": "north", "material": {"static_friction": 0.5}}]}]})";
}
std::string BallFile() {
  const TriangleMesh ball = MakeSphere(0.03, 80);
  std::ostringstream text;
  text.precision(17);
  for (const Vec3& v : ball.vertices) text << "v " << v.transpose() << '\n';
  for (const bool north : {false, true}) {
    text << (north ? "o north\n" : "o south\n");
    for (const auto& [i, j, k] : ball.triangles) {
      const double y = ball.vertices[i].y() + ball.vertices[j].y() + ball.vertices[k].y();
      if ((y > 0.0) == north) text << "f " << i + 1 << ' ' << j + 1 << ' ' << k + 1 << '\n';
    }
  }
  return text.str();
}

TEST_F(LoadedScene, RefinesAMeshThatStandsForACurvedSurfaceAndKeepsItsParts) {
  WriteFile(folder_ + "/ball.obj", BallFile());
  const auto load = [&](const std::string& curved) { return Load(CurvedText(curved)); };
  const Scene coarse = load("");
  const Scene off = load(", \"curved\": false");
  const Scene fine = load(", \"curved\": {\"tolerance_um\": 30}");
  EXPECT_TRUE(built_) << "not the coarse one's cache";
  EXPECT_EQ(coarse.objects[0].mesh.triangles.size(), 80u);
  EXPECT_EQ(off.objects[0].mesh.triangles.size(), 80u);
  EXPECT_GT(fine.objects[0].mesh.triangles.size(), 1280u);
  for (const Vec3& v : fine.objects[0].mesh.vertices) EXPECT_NEAR(v.norm(), 0.03, 100e-6);
  EXPECT_THAT(warnings_, IsEmpty());
  // What is felt is what is drawn: the bundle and the tree have the same mesh.
  EXPECT_EQ(PackScene(load(", \"curved\": {\"tolerance_um\": 30}")), PackScene(fine));
  EXPECT_FALSE(built_);
  const Body& ball = fine.objects[0];
  EXPECT_EQ(*std::max_element(ball.tree.leaf_triangle.begin(), ball.tree.leaf_triangle.end()) + 1,
            ball.mesh.triangles.size());
  std::size_t north = 0, south = 0;
  for (std::size_t i = 0; i < ball.tree.leaves(); ++i) {
    double lowest = 1.0, highest = -1.0;
    for (auto k = ball.tree.leaf_triangle_begin[i]; k < ball.tree.leaf_triangle_begin[i + 1]; ++k) {
      for (const std::uint32_t v : ball.mesh.triangles[ball.tree.leaf_triangle[k]]) {
        lowest = std::min(lowest, ball.mesh.vertices[v].y());
        highest = std::max(highest, ball.mesh.vertices[v].y());
      }
    }
    // The parts meet in a zigzag around the equator.
    if (lowest > 0.01) north += ball.leaf_material[i] == 1 ? 1 : 1000;
    if (highest < -0.01) south += ball.leaf_material[i] == 0 ? 1 : 1000;
  }
  EXPECT_GT(north, 4u);
  EXPECT_GT(south, 4u);
  EXPECT_LT(north + south, 64u) << "a leaf of one part has the other's material";
}

TEST_F(LoadedScene, SaysWhereTrianglesDoNotSufficeForTheTolerance) {
  WriteFile(folder_ + "/ball.obj", BallFile());
  const Scene scene = Load(CurvedText(R"(, "curved": {"tolerance_um": 5, "max_triangles": 3000})"));
  EXPECT_LE(scene.objects[0].mesh.triangles.size(), 3000u);
  EXPECT_THAT(warnings_,
              ElementsAre(HasSubstr("objects[0].mesh.curved: 3000 triangles do not suffice for 5 "
                                    "um; the mesh is true to 80 um with")));
}

TEST_F(LoadedScene, RefusesSpringsThatTheStepCannotComputeWith) {
  const auto write = [&](const char* tool, const char* torsional) {
    WriteFile(scene_, std::string(R"({"tools": [{"name": "rod", "mesh": )") + tool + R"(}],
  "objects": [{"name": "box", "mesh": {"file": "box.obj", "unit": "mm"}, "leaves": 64}],
  "coupling": {"stiffness_N_per_m": 1e5,
               "torsional_stiffness_Nm_per_rad": )" +
                          torsional + "}}");
  };
  // The rod reaches 0.05 m: 1e5 N/m times the square of a thousandth of that.
  const char* const rod = R"({"shape": "box", "size_m": [0.06, 0.08, 0.0001]}, "leaves": 64)";
  write(rod, "1e-4");
  EXPECT_THAT(Complaint(),
              HasSubstr("s.json:4: coupling.torsional_stiffness_Nm_per_rad: 0.0001 N m/rad is too "
                        "low for a stiffness of 100000 N/m, with a tool that extends 50 mm from "
                        "its centroid; give at least 0.000253, or a lower stiffness"));
  write(rod, "0.000253");
  Load();
  write(R"({"shape": "sphere", "radius_m": 0.005}, "leaves": 1)", "1e-4");
  Load();  // no contact turns a ball
}

std::string WithLeaves(const std::string& leaves, const std::string& more = "") {
  return R"({"tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": "auto"}],
    "objects": [{"name": "egg", "mesh": {"shape": "ellipsoid", "semi_axes_m": [0.04, 0.025, 0.03]}, "leaves": )" +
         leaves + more + "}]}";
}

TEST_F(LoadedScene, FindsTheLeavesThatAToleranceNeedsAndKeepsThem) {
  std::size_t before = 0;
  for (const std::string leaves : {"\"auto\"", R"({"tolerance_um": 400})"}) {
    WriteFile(scene_, WithLeaves(leaves));
    told_.clear();
    const Scene scene = Load();
    EXPECT_TRUE(built_);
    // 1/500 of the ellipsoid's diagonal, 112 mm, is 224 um; its mesh is slightly smaller.
    EXPECT_THAT(told_, ElementsAre(AllOf(testing::StartsWith("egg: "), HasSubstr(" leaves for "))));
    if (leaves[0] == '"') {
      EXPECT_THAT(told_[0], HasSubstr("for 22"));
    }
    EXPECT_NE(scene.objects[0].tree.leaves(), before);
    before = scene.objects[0].tree.leaves();
    // A sphere is exactly one ball: no count of leaves can be more accurate.
    EXPECT_EQ(scene.tools[0].tree.origin, TreeOrigin::kBall);
    EXPECT_THAT(scene.objects[0].remarks, IsEmpty());
    EXPECT_EQ(Load().objects[0].tree.leaves(), before);
    EXPECT_FALSE(built_);
  }
  EXPECT_EQ(Cached().size(), 2u);
}

TEST_F(LoadedScene, TakesAToleranceForThatOfTheSceneFile) {
  const std::size_t written = Load().objects[0].tree.leaves();
  EXPECT_EQ(written, 20u);
  options_.leaves = LeafTolerance{.most = 500e-6};
  const std::size_t loose = Load().objects[0].tree.leaves();
  options_.leaves->most = 250e-6;
  EXPECT_GT(Load().objects[0].tree.leaves(), loose);
  EXPECT_GE(loose, kFewestByTolerance);
  options_.leaves.reset();
  EXPECT_EQ(Load().objects[0].tree.leaves(), written);
  EXPECT_EQ(Cached().size(), 3u);
  const std::string bundle = folder_ + "/b.palpate";
  WriteFileAtomically(bundle, PackScene(Load()));
  options_.leaves = LeafTolerance{};
  EXPECT_THAT(ComplaintOf([&] { LoadScene(bundle, options_); }),
              AllOf(HasSubstr("b.palpate: is a bundle"), HasSubstr("omit the tolerance")));
}

TEST_F(LoadedScene, TellsHowMuchOfTheWholeSceneIsDoneWithoutGoingBack) {
  WriteFile(scene_, R"({
    "tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1}],
    "objects": [{"name": "a", "mesh": {"file": "box.obj", "unit": "mm"}, "leaves": 20},
                {"name": "again", "mesh": {"file": "box.obj", "unit": "mm"}, "leaves": 20},
                {"name": "b", "mesh": {"file": "box.obj", "unit": "mm"}, "leaves": 30,
                 "tree": "balanced"}]})");
  double before = 0.0;
  std::vector<std::string> bodies;
  options_.progress = [&](std::string_view stage, double fraction) {
    EXPECT_GE(fraction, before) << stage;
    EXPECT_LE(fraction, 1.0);
    before = fraction;
    const std::string body(stage.substr(0, stage.find(':')));
    if (bodies.empty() || bodies.back() != body) bodies.push_back(body);
  };
  options_.use_cache = false;
  options_.bodies_at_once = 1;
  LoadScene(scene_, options_);
  EXPECT_DOUBLE_EQ(before, 1.0);
  EXPECT_THAT(bodies, ElementsAre("body 1 of 3, ball", "body 2 of 3, a", "body 3 of 3, b"));
  before = 0.0;
  options_.bodies_at_once = 3;
  LoadScene(scene_, options_);
  EXPECT_DOUBLE_EQ(before, 1.0);
}

TEST_F(LoadedScene, IsTheSameHoweverManyBodiesAreBuiltAtOnce) {
  WriteFile(folder_ + "/ball.obj", BallFile());
  WriteFile(scene_, R"({
    "tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1}],
    "objects": [{"name": "slow", "mesh": {"file": "ball.obj", "unit": "m",
                   "curved": {"tolerance_um": 5, "max_triangles": 1000}}, "leaves": 100},
                {"name": "a", "mesh": {"file": "box.obj", "unit": "mm"}, "leaves": 20},
                {"name": "auto", "mesh": {"file": "ball.obj", "unit": "m"}, "leaves": "auto"},
                {"name": "again", "mesh": {"file": "box.obj", "unit": "mm"}, "leaves": 20},
                {"name": "small", "mesh": {"file": "ball.obj", "unit": "mm"}, "leaves": 40},
                {"name": "b", "mesh": {"file": "box.obj", "unit": "mm"}}]})");
  options_.use_cache = false;
  std::vector<std::string> said;
  const auto add = [&](const std::string& what) { said.push_back(what); };
  options_.warn = options_.tell = add;
  options_.bodies_at_once = 1;
  const std::vector<std::uint8_t> one = PackScene(LoadScene(scene_, options_));
  const std::vector<std::string> by_one = std::exchange(said, {});
  EXPECT_THAT(by_one, Contains(HasSubstr("triangles do not suffice")));
  EXPECT_THAT(by_one, Contains(HasSubstr("auto: ")));
  for (const std::size_t at_once : {0u, 5u}) {
    options_.bodies_at_once = at_once;
    EXPECT_EQ(PackScene(LoadScene(scene_, options_)), one) << at_once << " at once";
    EXPECT_EQ(said, by_one) << at_once << " at once";
    said.clear();
  }
}

TEST_F(LoadedScene, NamesTheBodyThatFailsFirstInTheFileWhicheverFailsFirst) {
  // Finding the broken one takes a while; the other does not exist.
  std::string broken;
  for (int i = 0; i < 20'000; ++i) broken += "v " + std::to_string(i) + " 0 0\n";
  WriteFile(folder_ + "/broken.obj", broken + "f 1 2 nonsense\n");
  const auto complaint = [&](const char* first, const char* second) {
    WriteFile(scene_, std::string(R"({
    "tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1}],
    "objects": [{"name": "a", )") +
                          first + R"(},
                {"name": "b", )" +
                          second + "}]}");
    return Complaint();
  };
  const char* const is_broken = R"("mesh": {"file": "broken.obj", "unit": "mm"}, "leaves": 20)";
  const char* const is_not_there = R"("mesh": {"file": "none.obj", "unit": "mm"}, "leaves": 20)";
  const char* const is_unpainted =
      R"("mesh": {"file": "box.obj", "unit": "mm"}, "leaves": 500, "regions": [
         {"sphere": {"centre_mm": [90, 0, 0], "radius_mm": 0.01}, "material": {}}])";
  options_.use_cache = false;
  for (const std::size_t at_once : {1u, 4u}) {
    options_.bodies_at_once = at_once;
    EXPECT_THAT(complaint(is_broken, is_not_there),
                AllOf(HasSubstr("objects[0].mesh: "), HasSubstr("broken.obj")));
    EXPECT_THAT(complaint(is_not_there, is_broken),
                AllOf(HasSubstr("objects[0].mesh: "), HasSubstr("none.obj")));
    // Found when the body is made, by which time a later body may have failed.
    EXPECT_THAT(complaint(is_unpainted, is_not_there), HasSubstr("objects[0].regions[0]: "));
  }
}

TEST_F(LoadedScene, KeepsTheRemarkThatAToleranceIsOutOfReach) {
  WriteFile(scene_, WithLeaves(R"({"tolerance_um": 1, "most_leaves": 70})"));
  for (int load = 0; load < 2; ++load) {
    const Scene scene = Load();
    EXPECT_EQ(scene.objects[0].tree.leaves(), 70u);
    EXPECT_THAT(
        ToText(JudgeScene(scene)),
        AllOf(HasSubstr("object egg: the tolerance of its leaves is not reached: 70 leaves"),
              HasSubstr("raise tolerance_um or most_leaves")));
  }
}

TEST_F(LoadedScene, BuildsTreesForTheContactThatIsAskedFor) {
  const Scene by_file = Load();
  EXPECT_EQ(by_file.features.contact, ContactModel::kSurface);
  EXPECT_EQ(by_file.objects[0].tree.origin, TreeOrigin::kInside);
  options_.contact = ContactModel::kSpheres;
  for (int load = 0; load < 2; ++load) {
    const Scene by_spheres = Load();
    EXPECT_EQ(built_, load == 0);
    EXPECT_EQ(by_spheres.features.contact, ContactModel::kSpheres);
    EXPECT_EQ(by_spheres.objects[0].tree.origin, TreeOrigin::kBalanced);
    EXPECT_EQ(by_spheres.objects[0].tree.leaves(), by_file.objects[0].tree.leaves());
    built_ = false;
  }
  options_.contact.reset();
  EXPECT_EQ(Load().objects[0].tree.origin, TreeOrigin::kInside);
  EXPECT_FALSE(built_);
}

TEST_F(LoadedScene, FitsFewLeavesWhereNobodyFeelsThemAndTheFileLeavesThemOut) {
  const auto leaves = [&](const std::string& fields) {
    WriteFile(scene_, R"({"tools": [{"name": "ball", "mesh": {"shape": "sphere",
      "radius_m": 0.005}, "leaves": 1}], "objects": [{"name": "egg", "mesh": {"shape": "ellipsoid",
      "semi_axes_m": [0.03, 0.02, 0.02], "triangles": 1280})" +
                          fields + "}]}");
    return Load().objects[0].tree.leaves();
  };
  const std::string rough = R"({"static_friction": 0.3})", soft = R"({"stiffness_N_per_m": 500})";
  EXPECT_LE(leaves(""), kInnerLeaves);
  EXPECT_LE(leaves(R"(, "material": )" + rough), kInnerLeaves);
  EXPECT_GE(leaves(R"(, "material": )" + soft), kFewestByTolerance);
  EXPECT_GE(leaves(R"(, "regions": [{"sphere": {"centre_mm": [30, 0, 0], "radius_mm": 15}, )"
                   R"("material": )" +
                   rough + "}]"),
            kFewestByTolerance);
  options_.contact = ContactModel::kSpheres;
  EXPECT_GE(leaves(""), kFewestByTolerance);
}

TEST_F(LoadedScene, MendsABrokenCacheAndSaysSo) {
  Load();
  ASSERT_EQ(Cached().size(), 1u);
  const std::string cached = Cached()[0];
  const std::string good = ReadWholeFile(cached);
  std::string flipped = good;
  flipped[good.size() / 2] ^= 1;
  for (const std::string& bad :
       {flipped, good.substr(0, good.size() / 2), std::string("junk"), std::string()}) {
    WriteFile(cached, bad);
    warnings_.clear();
    EXPECT_EQ(Load().objects[0].tree.leaves(), 20u);
    EXPECT_TRUE(built_);
    EXPECT_THAT(warnings_, ElementsAre(HasSubstr("it is being rebuilt")));
    EXPECT_EQ(ReadWholeFile(cached), good);
  }
}

TEST_F(LoadedScene, GoesOnWithoutACacheThatCannotBeWritten) {
  options_.cache_dir = WriteFile(folder_ + "/a-file", "x");
  EXPECT_EQ(Load().objects[0].tree.leaves(), 20u);
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("without being cached")));
}

TEST_F(LoadedScene, TakesNothingFromACacheThatOthersMayWriteTo) {
  Load();
  fs::permissions(options_.cache_dir, fs::perms::all | fs::perms::sticky_bit);
  EXPECT_EQ(Load().objects[0].tree.leaves(), 20u);
  EXPECT_TRUE(built_);
  EXPECT_THAT(warnings_, ElementsAre(AllOf(HasSubstr("others can write to it"),
                                           HasSubstr("without being cached"))));
}

TEST_F(LoadedScene, TakesNoLinkFromItsCache) {
  Load();
  const std::string cached = Cached()[0];
  fs::rename(cached, folder_ + "/elsewhere");
  fs::create_symlink(folder_ + "/elsewhere", cached);
  Load();
  EXPECT_TRUE(built_);
  EXPECT_THAT(warnings_, ElementsAre(HasSubstr("it is being rebuilt")));
  EXPECT_FALSE(fs::is_symlink(cached));
}

TEST_F(LoadedScene, TakesABundle) {
  const std::string bundle = folder_ + "/s.palpate";
  WriteFileAtomically(bundle, PackScene(Load()));
  EXPECT_EQ(PackScene(LoadScene(bundle)), PackScene(Load()));
  fs::resize_file(bundle, 100);
  EXPECT_THAT(ComplaintOf([&] { LoadScene(bundle); }), HasSubstr("s.palpate: is cut short"));
}

TEST_F(LoadedScene, LooksInTheCatalogueThatTheEnvironmentNames) {
  const Environment catalogue("PALPATE_CATALOGUE", folder_);
  EXPECT_EQ(LoadScene("s", options_).name, "s");
  EXPECT_THAT(CatalogueNames(), ElementsAre("s"));
}

TEST_F(LoadedScene, NamesLineAndFileOfAMeshThatIsMissingOrBroken) {
  fs::remove(folder_ + "/box.obj");
  EXPECT_THAT(Complaint(), HasSubstr("s.json:2: objects[0].mesh: "));
  EXPECT_THAT(Complaint(), HasSubstr("box.obj: No such file"));
  WriteFile(folder_ + "/box.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
  EXPECT_THAT(Complaint(), HasSubstr("the mesh has no extent"));
  WriteFile(folder_ + "/box.obj", "nonsense");
  EXPECT_THAT(Complaint(), HasSubstr("box.obj: the mesh has no triangles"));
}

TEST(Catalogue, HasAHandScriptForEveryScene) {
  for (const std::string& name : CatalogueNames()) {
    const std::string text = ReadWholeFile(FindSceneFile(name), 1 << 20);
    for (const BodyDescription& tool : ParseScene(text, FindSceneFile(name)).tools) {
      const PoseScript script = PoseScript::Load(ScriptFileBeside(name, tool.name));
      EXPECT_GE(script.duration(), 10.0) << name;
      // As a hand moves: the chapter assumes at most half a metre per second (2.3.4).
      double fastest = 0.0;
      for (double t = 0.001; t < script.duration(); t += 0.001) {
        fastest = std::max(fastest, (script.At(t).p - script.At(t - 0.001).p).norm() / 0.001);
      }
      EXPECT_GT(fastest, 0.01) << name << ' ' << tool.name;
      EXPECT_LT(fastest, 0.3) << name << ' ' << tool.name;
    }
  }
}

}  // namespace
}  // namespace palpate
