// The program palpate-scene, as people meet it.

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "scenes/catalogue.h"
#include "scenes/scene_verdict.h"
#include "scenes/tree/coverage.h"
#include "tests/scenes/support.h"
#include "tests/support/dirty_mesh.h"
#include "tests/support/program.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using test::FreshFolder;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

struct Outcome {
  int exit_code = -1;
  std::string text;
};

Outcome PalpateScene(const std::string& arguments, const std::string& folder) {
  const std::string command =
      "XDG_CACHE_HOME=" + folder + " " + PALPATE_BIN_DIR + "/palpate-scene " + arguments + " 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  Outcome run;
  char block[4096];
  while (const std::size_t got = fread(block, 1, sizeof block, pipe)) run.text.append(block, got);
  run.exit_code = WEXITSTATUS(pclose(pipe));
  return run;
}

/// The scene file of a ball on an ellipsoid of few triangles: a tree of many takes seconds.
std::string EggScene(const std::string& folder, int leaves = 512) {
  return test::WriteFile(folder + "/egg.json", R"({
    "tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1}],
    "objects": [{"name": "egg", "mesh": {"shape": "ellipsoid", "semi_axes_m": [0.04, 0.025, 0.03],
                                         "triangles": 1280}, "leaves": )" +
                                                   std::to_string(leaves) + "}]}");
}

TEST(PalpateScene, BuildsABundleAndTellsWhatIsInIt) {
  const std::string folder = FreshFolder();
  const Outcome build =
      PalpateScene("build " + EggScene(folder) + " -o " + folder + "/e.palpate", folder);
  EXPECT_EQ(build.exit_code, 0) << build.text;
  EXPECT_TRUE(std::filesystem::exists(folder + "/e.palpate"));
  const Outcome info = PalpateScene("info " + folder + "/e.palpate", folder);
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.text, HasSubstr("tool ball: 1 leaves"));
  EXPECT_THAT(info.text, HasSubstr("object egg: 512 leaves in 3 levels"));
  EXPECT_THAT(info.text, HasSubstr("512 spheres in    64 packets (100 % full)"));
  const Outcome render =
      PalpateScene("render " + folder + "/e.palpate -o " + folder + "/e.png", folder);
  EXPECT_EQ(render.exit_code, 0) << render.text;
  EXPECT_TRUE(std::filesystem::exists(folder + "/e.png"));
}

TEST(PalpateScene, TellsHowFarEachLevelIsFromTheMeshAndInWhichMode) {
  const std::string folder = FreshFolder();
  const std::string bundle = folder + "/e.palpate";
  const std::string scene = EggScene(folder, 100);
  const Outcome build = PalpateScene("build " + scene + " --mode balanced -o " + bundle, folder);
  EXPECT_THAT(build.text, HasSubstr("100 leaves in 3 levels, mode \"balanced\""));
  EXPECT_THAT(build.text, HasSubstr("tool ball: 1 leaves in 1 levels, exactly the ball it is"));
  const Outcome info = PalpateScene(
      "info " + bundle + " --samples 1009 --csv " + folder + "/e.csv --json -", folder);
  EXPECT_EQ(info.exit_code, 0) << info.text;
  EXPECT_THAT(info.text, HasSubstr("100 leaves in 3 levels, mode \"balanced\""));
  EXPECT_THAT(info.text, HasSubstr("1, bounds"));
  EXPECT_THAT(info.text, HasSubstr("3, leaves"));
  EXPECT_THAT(info.text, HasSubstr("a single ball is what it is"));
  EXPECT_THAT(info.text, HasSubstr("bound the leaves below them (for the contact prediction)"));
  const std::string csv = ReadWholeFile(folder + "/e.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_THAT(csv, testing::StartsWith("body,mode,level,kind,spheres,outside_um_mean"));
  EXPECT_THAT(csv, HasSubstr("\negg,balanced,3,leaves,100,"));
  const std::size_t json = info.text.find('{');
  ASSERT_NE(json, std::string::npos);
  EXPECT_THAT(info.text.substr(json), HasSubstr("\"mode\": \"ball\",\n      \"levels\": []"));
  const Outcome both = PalpateScene("info " + bundle + " --csv - --json -", folder);
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_THAT(both.text, HasSubstr("give one of them a file"));

  const Outcome picture =
      PalpateScene("render " + bundle + " --error --body egg -o " + folder + "/e.png", folder);
  EXPECT_EQ(picture.exit_code, 0) << picture.text;
  EXPECT_TRUE(std::filesystem::exists(folder + "/e.png"));
  const Outcome whose =
      PalpateScene("render " + bundle + " --body egg -o " + folder + "/f.png", folder);
  EXPECT_EQ(whose.exit_code, 2);
  EXPECT_THAT(whose.text, HasSubstr("--body chooses whose --error is drawn"));
  const Outcome loose = PalpateScene("build " + scene + " --tolerance-um 800", folder);
  EXPECT_THAT(loose.text, HasSubstr("egg: 64 leaves for 800 um: "));
  EXPECT_EQ(PalpateScene("build " + scene + " --tolerance-um 0", folder).exit_code, 2);
}

TEST(PalpateScene, BuildsTreesInTheModeThatIsNamed) {
  const std::string folder = FreshFolder();
  const std::string egg = EggScene(folder);
  const auto outside = [&](const std::string& mode) {
    const std::string bundle = folder + "/" + mode + ".palpate";
    const Outcome build =
        PalpateScene("build " + egg + " --mode " + mode + " -o " + bundle, folder);
    EXPECT_EQ(build.exit_code, 0) << build.text;
    const Scene scene = LoadScene(bundle);
    return MeasureCoverage(scene.objects[0].mesh, scene.objects[0].tree).outside.max;
  };
  // One cache for both: neither is taken for the other.
  EXPECT_LT(outside("inside"), 1e-6);
  EXPECT_GT(outside("balanced"), 1e-5);
  EXPECT_LT(outside("inside"), 1e-6);
}

TEST(PalpateScene, ExportsTreesAndTakesThemBack) {
  const std::string folder = FreshFolder();
  const std::string egg = EggScene(folder);
  for (const std::string ending : {"sph", "ply", "glb"}) {
    const std::string file = folder + "/e." + ending;
    const Outcome exported = PalpateScene("export " + egg + " -o " + file, folder);
    EXPECT_EQ(exported.exit_code, 0) << exported.text;
    EXPECT_THAT(exported.text, HasSubstr("wrote " + file + ": the tree of egg"));
    EXPECT_TRUE(std::filesystem::exists(file));
  }
  test::WriteFile(folder + "/s.json", R"({
    "tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1}],
    "objects": [{"name": "egg", "tree": {"file": "e.sph", "unit": "mm"},
                 "mesh": {"shape": "ellipsoid", "semi_axes_m": [0.04, 0.025, 0.03]}}]})");
  const Outcome build = PalpateScene("build " + folder + "/s.json --mode cover", folder);
  EXPECT_EQ(build.exit_code, 0) << build.text;
  EXPECT_THAT(build.text,
              HasSubstr("egg: " + folder + "/e.sph: level 4 of 4, 512 balls, moved by"));
  EXPECT_THAT(build.text, HasSubstr("objects[0].tree: is a tree from a file"));
  EXPECT_THAT(build.text, HasSubstr("object egg: 512 leaves in 3 levels"));

  const Outcome body = PalpateScene("export " + egg + " --body eg -o " + folder + "/f.ply", folder);
  EXPECT_EQ(body.exit_code, 2) << body.text;
  EXPECT_THAT(body.text, HasSubstr("did you mean \"egg\"?"));
  const Outcome ball =
      PalpateScene("export " + egg + " --body ball -o " + folder + "/f.ply", folder);
  EXPECT_THAT(ball.text, HasSubstr("the tree of ball"));
  const Outcome ending = PalpateScene("export " + egg + " -o " + folder + "/f.obj", folder);
  EXPECT_EQ(ending.exit_code, 2) << ending.text;
  EXPECT_THAT(ending.text, HasSubstr("give .sph"));
  EXPECT_FALSE(std::filesystem::exists(folder + "/f.obj"));
  const Outcome help = PalpateScene("export --help", folder);
  EXPECT_EQ(help.exit_code, 0);
  EXPECT_THAT(help.text, HasSubstr("Example: palpate-scene export"));
}

TEST(PalpateScene, SaysWhatAModeCanBeAndOfWhat) {
  const std::string folder = FreshFolder();
  const Outcome unknown = PalpateScene("build " + EggScene(folder) + " --mode outside", folder);
  EXPECT_EQ(unknown.exit_code, 2) << unknown.text;
  EXPECT_THAT(unknown.text, HasSubstr("inside"));
  EXPECT_THAT(unknown.text, HasSubstr("balanced"));
  const std::string bundle = folder + "/e.palpate";
  ASSERT_EQ(PalpateScene("build " + EggScene(folder) + " -o " + bundle, folder).exit_code, 0);
  const Outcome built = PalpateScene("build " + bundle + " --mode balanced", folder);
  EXPECT_EQ(built.exit_code, 1) << built.text;
  EXPECT_THAT(built.text, HasSubstr("e.palpate: is a bundle, whose trees are built"));
  EXPECT_THAT(built.text, HasSubstr("give the scene file or leave the mode out"));
}

TEST(PalpateScene, ChecksScenesAndMeshes) {
  const std::string folder = FreshFolder();
  const Outcome scene = PalpateScene("check cube", folder);
  EXPECT_EQ(scene.exit_code, 0) << scene.text;
  EXPECT_THAT(scene.text, HasSubstr("outside   mean 0.0  p99 0.0  max 0.0 um"));
  EXPECT_THAT(scene.text, HasSubstr("uncovered mean "));
  EXPECT_THAT(scene.text, EndsWith("verdict: good to touch\n"));
  const std::string mesh =
      test::WriteFile(folder + "/t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Outcome open = PalpateScene("check " + mesh, folder);
  EXPECT_EQ(open.exit_code, 0) << open.text;
  EXPECT_THAT(open.text, HasSubstr("closed no"));
  EXPECT_THAT(open.text, HasSubstr("note: 3 edges are open"));
  EXPECT_THAT(open.text,
              HasSubstr("verdict: usable with these limits:\n  - object t: 3 edges are open"));
  const std::string points =
      test::WriteFile(folder + "/p.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n");
  const Outcome nothing = PalpateScene("check " + points, folder);
  EXPECT_EQ(nothing.exit_code, 1) << nothing.text;
  EXPECT_THAT(nothing.text, HasSubstr("verdict: not usable:\n  - mesh: the mesh has no "));
}

TEST(PalpateScene, WarnsOfPartsThatOverlap) {
  const std::string folder = FreshFolder();
  const std::string mesh = test::WriteFile(  // a box, and a second one in it
      folder + "/tooth.obj", "o crown\n" + test::ObjOf(MakeBox(Vec3::Constant(10.0))) + "o gum\n" +
                                 test::ObjOf(MakeBox(Vec3::Constant(4.0)), 8));
  const Outcome alone = PalpateScene("check " + mesh, folder);
  EXPECT_EQ(alone.exit_code, 0) << alone.text;
  EXPECT_THAT(alone.text,
              HasSubstr("warning: parts overlap: 14 % of the surface lies inside other"));
  EXPECT_THAT(alone.text, HasSubstr(", of \"gum\"; "));
  EXPECT_EQ(PalpateScene("new " + mesh + " -o " + folder + "/tooth.json", folder).exit_code, 0);
  const Outcome scene = PalpateScene("check " + folder + "/tooth.json", folder);
  EXPECT_EQ(scene.exit_code, 0) << scene.text;
  EXPECT_THAT(scene.text, HasSubstr("verdict: usable with these limits:\n  - object tooth: parts "
                                    "overlap: 14 % of the surface lies inside other parts"));
}

/// What a program says from its verdict on; each finding of a server's is a line of its log.
std::string VerdictOf(const Outcome& run) {
  const std::size_t at = run.text.find("verdict: ");
  if (at == std::string::npos) return "none: " + run.text;
  const std::size_t end = run.text.find("palpate-scene: ", at);
  return run.text.substr(at, end == std::string::npos ? end : end - at);
}

TEST(PalpateScene, ChecksBuildsAndInformsWithTheServersVerdict) {
  const std::string folder = FreshFolder();
  test::Random random(3);
  TriangleMesh soup = test::Unwelded(MakeSphere(0.02, 320), 4e-8, random);
  test::TurnSome(soup, 0.05, random);
  soup = test::Both(soup, MakeSphere(0.019, 320));
  const std::string mesh = test::WriteFile(folder + "/soup.obj", test::ObjOf(soup));
  const std::string bundle = folder + "/soup.palpate";
  const std::string check = VerdictOf(PalpateScene("check " + mesh, folder));
  EXPECT_THAT(check, testing::AllOf(HasSubstr("usable with these limits"), HasSubstr("welded"),
                                    HasSubstr("they are turned"), HasSubstr("parts overlap")));
  LoadOptions options;
  options.cache_dir = folder + "/palpate";
  options.tell = [](const std::string&) {};
  EXPECT_EQ(ToText(JudgeScene(LoadScene(mesh, options))), check) << "which the server logs";
  EXPECT_EQ(VerdictOf(PalpateScene("info " + mesh, folder)), check);
  const Outcome build = PalpateScene("build " + mesh + " -o " + bundle, folder);
  EXPECT_EQ(build.exit_code, 0) << build.text;
  EXPECT_EQ(VerdictOf(build).find(check), 0u) << build.text;
  EXPECT_EQ(VerdictOf(PalpateScene("check " + bundle, folder)), check) << "what was mended stays";
}

TEST(PalpateScene, ChecksBuildsAndInformsAsFailuresOfWhatIsNotUsable) {
  const std::string folder = FreshFolder();
  const std::string scene = test::WriteFile(
      folder + "/bare.json",
      R"({"contact":"spheres","tools":[{"name":"b","mesh":{"shape":"sphere","radius_m":0.01},
"leaves":1}],"objects":[{"name":"o","mesh":{"shape":"box","size_m":[0.1,0.2,0.3]},"leaves":1}]})");
  const std::string bundle = folder + "/bare.palpate";
  for (const std::string& command :
       {std::string("check "), std::string("info "), "build -o " + bundle + " "}) {
    const Outcome run = PalpateScene(command + scene, folder);
    EXPECT_EQ(run.exit_code, 1) << command << run.text;
    EXPECT_THAT(run.text, HasSubstr("verdict: not usable:\n  - object o: a hundredth"));
  }
  EXPECT_FALSE(std::filesystem::exists(bundle));
}

/// What stands in a folder, by name, with its contents.
std::map<std::string, std::string> FilesIn(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files[entry.path().filename()] = ReadWholeFile(entry.path());
  }
  return files;
}

TEST(PalpateScene, LeavesNothingBehindWhereCtrlCEndsABuild) {
  const std::string folder = FreshFolder();
  const std::string cache = folder + "/cache", out = folder + "/out";
  std::filesystem::create_directories(out);
  const auto scene = [&](const std::string& name, int leaves) {
    return test::WriteFile(
        folder + "/" + name + ".json",
        R"({"tools":[{"name":"b","mesh":{"shape":"sphere","radius_m":0.01},"leaves":1}],
"objects":[{"name":"o","mesh":{"shape":"ellipsoid","semi_axes_m":[0.1,0.2,0.3]},"leaves":)" +
            std::to_string(leaves) + "}]}");
  };
  const std::string small = scene("small", 64);
  ASSERT_EQ(PalpateScene("build " + small + " --cache " + cache, folder).exit_code, 0);
  const auto before = FilesIn(cache);
  ASSERT_EQ(before.size(), 1u);
  test::Program build(
      test::OwnFolder() + "/palpate-scene",
      {"build", scene("large", 500'000), "--cache", cache, "-o", out + "/x.palpate"});
  ASSERT_TRUE(build.Says("touching balls")) << build.Output();
  build.Signal(SIGINT);
  EXPECT_EQ(build.Exit(), -SIGINT);
  EXPECT_TRUE(std::filesystem::is_empty(out));
  EXPECT_EQ(FilesIn(cache), before);
  const Outcome again = PalpateScene("info " + small + " --cache " + cache, folder);
  EXPECT_EQ(again.exit_code, 0) << again.text;
  EXPECT_THAT(again.text, Not(HasSubstr("touching balls"))) << "it is not built anew";
}

TEST(PalpateScene, ListsTheCatalogue) {
  const Outcome list = PalpateScene("list", FreshFolder());
  EXPECT_EQ(list.exit_code, 0) << list.text;
  for (const std::string& name : CatalogueNames()) EXPECT_THAT(list.text, HasSubstr(name + " "));
  EXPECT_THAT(list.text, HasSubstr("cube              A ball of 5 mm radius on a cube"));
}

TEST(PalpateScene, EndsWithOneForAFailureAndTwoForWrongUsage) {
  const std::string folder = FreshFolder();
  for (const std::string wrong :
       {"", "fly", "build", "render cube", "render cube -o x.png --level 9",
        "render cube -o x.png --whole --level 1", "render cube -o x.jpg", "render cube -o x"}) {
    EXPECT_EQ(PalpateScene(wrong, folder).exit_code, 2) << wrong;
  }
  EXPECT_THAT(PalpateScene("render cube -o x.jpg", folder).text,
              HasSubstr("-o x.jpg: pictures are PNG; give a name that ends in .png"));
  const Outcome missing = PalpateScene("info nothing", folder);
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.text, HasSubstr("palpate-scene: there is no scene \"nothing\""));
}

TEST(PalpateScene, RefusesAFileThatTakesTooMuchTime) {
  // In the importer's place, one that a file holds up, with less time.
  const std::string folder = FreshFolder();
  const std::string scene = folder + "/palpate-scene", importer = folder + "/palpate-import";
  std::filesystem::copy_file(test::OwnFolder() + "/palpate-scene", scene);
  test::WriteFile(importer, "#!/bin/sh\nulimit -t 1\nwhile :; do :; done\n");
  std::filesystem::permissions(importer, std::filesystem::perms::owner_all);
  const std::string file =
      test::WriteFile(folder + "/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  test::Program program(scene, {"check", file});
  EXPECT_EQ(program.Exit(60.0), 1);
  EXPECT_THAT(program.Output(),
              testing::AllOf(HasSubstr("palpate-scene: " + file + ": was not read within"),
                             HasSubstr("export it again, or simplify it")));
}

}  // namespace
}  // namespace palpate
