#include "scenes/files/mesh_scene.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/catalogue.h"
#include "scenes/files/scene_file.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using test::FreshFolder;
using test::WriteFile;
using testing::Contains;
using testing::HasSubstr;

/// A tetrahedron whose longest side is that of its bounding box.
std::string Tetrahedron(const std::string& side) {
  return "v 0 0 0\nv " + side + " 0 0\nv 0 " + side + " 0\nv 0 0 " + side +
         "\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
}

SceneDescription Parsed(const MeshScene& scene, const std::string& folder) {
  return ParseScene(scene.text, folder + "/scene.json");
}

TEST(GuessUnit, TakesWhatIsNearerToTheSizeOfWhatAHandFeels) {
  EXPECT_EQ(GuessUnit(0.011), "m");
  EXPECT_EQ(GuessUnit(0.15), "m");
  EXPECT_EQ(GuessUnit(1.0), "m");
  EXPECT_EQ(GuessUnit(2.0), "mm");
  EXPECT_EQ(GuessUnit(22.0), "mm");
  EXPECT_EQ(GuessUnit(800.0), "mm");
}

TEST(MeshScene, HasTheMeshInTheGuessedUnitAndABallAboveIt) {
  const std::string folder = FreshFolder();
  const std::string mesh = WriteFile(folder + "/my tooth.v2.obj", Tetrahedron("20"));
  const MeshScene scene = MakeMeshScene(mesh, {}, folder);
  EXPECT_EQ(scene.name, "my-tooth.v2");
  const SceneDescription parsed = Parsed(scene, folder);
  EXPECT_EQ(parsed.name, "my-tooth.v2");
  ASSERT_EQ(parsed.objects.size(), 1u);
  EXPECT_EQ(parsed.objects[0].mesh.what, mesh);
  EXPECT_EQ(parsed.objects[0].mesh.placement.metres_per_unit, 1e-3);
  ASSERT_EQ(parsed.tools.size(), 1u);
  EXPECT_EQ(parsed.tools[0].leaves, 1u);
  EXPECT_DOUBLE_EQ(parsed.tools[0].mesh.size.x(), 0.001) << "a twentieth";
  EXPECT_GT(parsed.tools[0].X_WB.p.y(), 0.010 + 0.001);
  EXPECT_THAT(scene.assumptions,
              Contains(HasSubstr("unit: mm, guessed by the size, so it is 20 x "
                                 "20 x 20 mm; in m it would be 20 x 20 x 20 m")));
  EXPECT_THAT(scene.assumptions, Contains(HasSubstr("1 mm radius")));
  EXPECT_THAT(scene.assumptions, Contains(HasSubstr("contact: by the mesh's own triangles")));
}

TEST(MeshScene, TakesTheUnitAndTheBallThatAreGiven) {
  const std::string folder = FreshFolder();
  const std::string mesh = WriteFile(folder + "/part.obj", Tetrahedron("20"));
  const MeshScene scene = MakeMeshScene(mesh, {.unit = "cm", .ball_m = 0.004}, folder);
  const SceneDescription parsed = Parsed(scene, folder);
  EXPECT_EQ(parsed.objects[0].mesh.placement.metres_per_unit, 0.01);
  EXPECT_DOUBLE_EQ(parsed.tools[0].mesh.size.x(), 0.004);
  EXPECT_THAT(scene.assumptions, Contains(HasSubstr("unit: cm, as given, so it is 200 x 200")));
}

TEST(MeshScene, WritesNumbersAsPeopleDo) {
  const std::string folder = FreshFolder();
  const std::string mesh = WriteFile(folder + "/tooth.obj", Tetrahedron("20.474"));
  EXPECT_THAT(MakeMeshScene(mesh, {}, folder).text,
              testing::AllOf(HasSubstr("0.00102\n"), HasSubstr("16.4,\n")));
}

TEST(MeshScene, SaysWhereTheSizeIsUnusual) {
  const std::string folder = FreshFolder();
  const std::string mesh = WriteFile(folder + "/hall.obj", Tetrahedron("20"));
  EXPECT_THAT(MakeMeshScene(mesh, {.unit = "m"}, folder).assumptions,
              Contains(HasSubstr("an unusual size for an object to feel")));
}

TEST(MeshScene, NamesTheMeshFromTheFolderOfTheSceneFile) {
  const std::string folder = FreshFolder();
  std::filesystem::create_directories(folder + "/scenes");
  const std::string mesh = WriteFile(folder + "/part.obj", Tetrahedron("20"));
  const MeshScene scene = MakeMeshScene(mesh, {}, folder + "/scenes");
  EXPECT_EQ(Parsed(scene, folder + "/scenes").objects[0].mesh.what, mesh);
}

TEST(MeshScene, RefusesWhatIsNoMesh) {
  const std::string folder = FreshFolder();
  EXPECT_THAT(ComplaintOf([&] { MakeMeshScene(folder + "/none.stl", {}, folder); }),
              HasSubstr("none.stl"));
  const std::string flat = WriteFile(folder + "/point.obj", "v 1 1 1\nf 1 1 1\n");
  EXPECT_THAT(ComplaintOf([&] { MakeMeshScene(flat, {}, folder); }), HasSubstr("point.obj"));
}

TEST(LoadScene, SaysWhatToBringInPlaceOfWhatIsNeitherSceneNorMesh) {
  const std::string folder = FreshFolder();
  const std::string step = WriteFile(folder + "/part.step", "ISO-10303-21;\nHEADER;\n");
  EXPECT_THAT(ComplaintOf([&] { LoadScene(step); }),
              HasSubstr("part.step: is neither a scene nor a supported mesh; give a scene "
                        "file (.json), a bundle (.palpate), or export the mesh as .stl"));
}

TEST(LoadScene, MakesASceneOfAMeshAndTellsWhatItAssumed) {
  const std::string folder = FreshFolder();
  const std::string mesh = WriteFile(folder + "/part.obj", Tetrahedron("20"));
  std::vector<std::string> told;
  LoadOptions options;
  options.cache_dir = folder + "/cache";
  options.tell = [&](const std::string& text) { told.push_back(text); };
  const auto side = [&](const std::string& unit) {
    options.mesh.unit = unit;
    const Scene scene = LoadScene(mesh, options);
    EXPECT_EQ(scene.name, "part");
    double most = 0.0;
    for (const Vec3& v : scene.objects[0].mesh.vertices) most = std::max(most, v.maxCoeff());
    return 2.0 * most;
  };
  EXPECT_NEAR(side(""), 0.020, 1e-12);
  EXPECT_NEAR(side("cm"), 0.200, 1e-12) << "not what the cache has of it in mm";
  EXPECT_THAT(told, Contains(HasSubstr("palpate-scene new " + mesh + " -o part.json")));
}

}  // namespace
}  // namespace palpate
