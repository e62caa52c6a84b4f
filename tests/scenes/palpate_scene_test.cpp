
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "scenes/catalogue.h"
#include "scenes/scene_verdict.h"
#include "scenes/tree/tree_error.h"
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

class PalpateScene : public testing::Test {
 protected:
  /// Returns the program's output; expects the given exit code.
  std::string Run(const std::string& arguments, int exit_code = 0) const {
    const std::string command = "XDG_CACHE_HOME=" + folder + " " + PALPATE_BIN_DIR +
                                "/palpate-scene " + arguments + " 2>&1";
    std::FILE* const pipe = popen(command.c_str(), "r");
    std::string text;
    char block[4096];
    while (const std::size_t got = fread(block, 1, sizeof block, pipe)) text.append(block, got);
    EXPECT_EQ(WEXITSTATUS(pclose(pipe)), exit_code) << arguments << "\n" << text;
    return text;
  }
  bool Exists(const std::string& file) const {
    return std::filesystem::exists(folder + "/" + file);
  }
  std::string Write(const std::string& file, const std::string& text) const {
    return test::WriteFile(folder + "/" + file, text);
  }
  /// A scene of a ball on an ellipsoid with few triangles: a tree of many would take seconds.
  std::string EggScene(int leaves = 512) const {
    return Write("egg.json", R"({
    "tools": [{"name": "ball", "mesh": {"shape": "sphere", "radius_m": 0.005}, "leaves": 1}],
    "objects": [{"name": "egg", "mesh": {"shape": "ellipsoid", "semi_axes_m": [0.04, 0.025, 0.03],
                                         "triangles": 1280}, "leaves": )" +
                                 std::to_string(leaves) + "}]}");
  }

  const std::string folder = FreshFolder();
};

TEST_F(PalpateScene, BuildsABundleAndTellsWhatIsInIt) {
  const std::string build = Run("build " + EggScene() + " -o " + folder + "/e.palpate");
  EXPECT_TRUE(Exists("e.palpate"));
  const std::string info = Run("info " + folder + "/e.palpate");
  EXPECT_THAT(info, HasSubstr("tool ball: 1 leaves"));
  EXPECT_THAT(info, HasSubstr("object egg: 512 leaves in 3 levels"));
  EXPECT_THAT(info, HasSubstr("512 spheres in    64 packets (100 % full)"));
  const std::string render = Run("render " + folder + "/e.palpate -o " + folder + "/e.png");
  EXPECT_TRUE(Exists("e.png"));
}

TEST_F(PalpateScene, TellsHowFarEachLevelIsFromTheMeshAndInWhichMode) {
  const std::string bundle = folder + "/e.palpate";
  const std::string scene = EggScene(100);
  const std::string build = Run("build " + scene + " --mode balanced -o " + bundle);
  EXPECT_THAT(build, HasSubstr("100 leaves in 3 levels, mode \"balanced\""));
  EXPECT_THAT(build, HasSubstr("tool ball: 1 leaves in 1 levels, exactly the ball it is"));
  const std::string info = Run("info " + bundle);
  EXPECT_THAT(info, HasSubstr("100 leaves in 3 levels, mode \"balanced\""));
  EXPECT_THAT(info, HasSubstr("1, bounds"));
  EXPECT_THAT(info, HasSubstr("3, leaves"));
  EXPECT_THAT(info, HasSubstr("a single ball is exact"));
  EXPECT_THAT(info, HasSubstr("bound the leaves below them (for the contact prediction)"));
  EXPECT_THAT(Run("build " + scene + " --tolerance-um 800"),
              HasSubstr("egg: 64 leaves for 800 um: "));
  Run("build " + scene + " --tolerance-um 0", 2);
}

TEST_F(PalpateScene, SaysWhatAModeCanBeAndOfWhat) {
  const std::string unknown = Run("build " + EggScene() + " --mode outside", 2);
  EXPECT_THAT(unknown, HasSubstr("inside"));
  EXPECT_THAT(unknown, HasSubstr("balanced"));
  const std::string bundle = folder + "/e.palpate";
  Run("build " + EggScene() + " -o " + bundle);
  const std::string built = Run("build " + bundle + " --mode balanced", 1);
  EXPECT_THAT(built, HasSubstr("e.palpate: is a bundle, whose trees cannot be changed"));
  EXPECT_THAT(built, HasSubstr("give the scene file, or omit the mode"));
}

TEST_F(PalpateScene, ChecksScenesAndMeshes) {
  const std::string scene = Run("check cube");
  EXPECT_THAT(scene, HasSubstr("outside   mean 0.0  p99 0.0  max 0.0 um"));
  EXPECT_THAT(scene, HasSubstr("uncovered mean "));
  EXPECT_THAT(scene, EndsWith("verdict: good to touch\n"));
  const std::string mesh = Write("t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string open = Run("check " + mesh);
  EXPECT_THAT(open, HasSubstr("closed no"));
  EXPECT_THAT(open, HasSubstr("note: 3 edges are open"));
  EXPECT_THAT(open,
              HasSubstr("verdict: usable with these limits:\n  - object t: 3 edges are open"));
  const std::string points = Write("p.obj", "v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n");
  EXPECT_THAT(Run("check " + points, 1),
              HasSubstr("verdict: not usable:\n  - mesh: the mesh has no "));
}

TEST_F(PalpateScene, WarnsOfPartsThatOverlap) {
  const std::string mesh = test::WriteFile(  // one box inside another
      folder + "/tooth.obj", "o crown\n" + test::ObjOf(MakeBox(Vec3::Constant(10.0))) + "o gum\n" +
                                 test::ObjOf(MakeBox(Vec3::Constant(4.0)), 8));
  const std::string alone = Run("check " + mesh);
  EXPECT_THAT(alone, HasSubstr("warning: parts overlap: 14 % of the surface lies inside other"));
  EXPECT_THAT(alone, HasSubstr(", of \"gum\"; "));
  Run("new " + mesh + " -o " + folder + "/tooth.json");
  const std::string scene = Run("check " + folder + "/tooth.json");
  EXPECT_THAT(scene, HasSubstr("verdict: usable with these limits:\n  - object tooth: parts "
                               "overlap: 14 % of the surface lies inside other parts"));
}

/// Output from the verdict on; each finding of a server is one line of its log.
std::string VerdictOf(const std::string& text) {
  const std::size_t at = text.find("verdict: ");
  if (at == std::string::npos) return "none: " + text;
  const std::size_t end = text.find("palpate-scene: ", at);
  return text.substr(at, end == std::string::npos ? end : end - at);
}

TEST_F(PalpateScene, ChecksBuildsAndInformsWithTheServersVerdict) {
  test::Random random(3);
  TriangleMesh soup = test::Unwelded(MakeSphere(0.02, 320), 4e-8, random);
  test::TurnSome(soup, 0.05, random);
  soup = test::Both(soup, MakeSphere(0.019, 320));
  const std::string mesh = Write("soup.obj", test::ObjOf(soup));
  const std::string bundle = folder + "/soup.palpate";
  const std::string check = VerdictOf(Run("check " + mesh));
  EXPECT_THAT(check, testing::AllOf(HasSubstr("usable with these limits"), HasSubstr("welded"),
                                    HasSubstr("they are turned"), HasSubstr("parts overlap")));
  LoadOptions options;
  options.cache_dir = folder + "/palpate";
  options.tell = [](const std::string&) {};
  EXPECT_EQ(ToText(JudgeScene(LoadScene(mesh, options))), check) << "which the server logs";
  EXPECT_EQ(VerdictOf(Run("info " + mesh)), check);
  const std::string build = Run("build " + mesh + " -o " + bundle);
  EXPECT_EQ(VerdictOf(build).find(check), 0u) << build;
  EXPECT_EQ(VerdictOf(Run("check " + bundle)), check) << "what was mended stays";
}

TEST_F(PalpateScene, ChecksBuildsAndInformsAsFailuresOfWhatIsNotUsable) {
  const std::string scene =
      Write("bare.json",
            R"({"contact":"spheres","tools":[{"name":"b","mesh":{"shape":"sphere","radius_m":0.01},
"leaves":1}],"objects":[{"name":"o","mesh":{"shape":"box","size_m":[0.1,0.2,0.3]},"leaves":1}]})");
  const std::string bundle = folder + "/bare.palpate";
  for (const std::string& command :
       {std::string("check "), std::string("info "), "build -o " + bundle + " "}) {
    EXPECT_THAT(Run(command + scene, 1),
                HasSubstr("verdict: not usable:\n  - object o: 1 % of its surface"));
  }
  EXPECT_FALSE(std::filesystem::exists(bundle));
}

/// A folder's files and their contents.
std::map<std::string, std::string> FilesIn(const std::string& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files[entry.path().filename()] = ReadWholeFile(entry.path());
  }
  return files;
}

TEST_F(PalpateScene, LeavesNothingBehindWhereCtrlCEndsABuild) {
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
  Run("build " + small + " --cache " + cache);
  const auto before = FilesIn(cache);
  ASSERT_EQ(before.size(), 1u);
  test::Program build(
      test::OwnFolder() + "/palpate-scene",
      {"build", scene("large", 500'000), "--cache", cache, "-o", out + "/x.palpate"});
  ASSERT_TRUE(build.Says("fitting balls")) << build.Output();
  build.Signal(SIGINT);
  EXPECT_EQ(build.Exit(), -SIGINT);
  EXPECT_TRUE(std::filesystem::is_empty(out));
  EXPECT_EQ(FilesIn(cache), before);
  EXPECT_THAT(Run("info " + small + " --cache " + cache), Not(HasSubstr("fitting balls")))
      << "it is not built anew";
}

TEST_F(PalpateScene, EndsWithOneForAFailureAndTwoForWrongUsage) {
  for (const std::string wrong :
       {"", "fly", "build", "render cube", "render cube -o x.png --level 9",
        "render cube -o x.png --whole --level 1", "render cube -o x.jpg", "render cube -o x"}) {
    Run(wrong, 2);
  }
  EXPECT_THAT(Run("render cube -o x.jpg", 2),
              HasSubstr("-o x.jpg: pictures are PNG; give a name that ends in .png"));
  EXPECT_THAT(Run("info nothing", 1), HasSubstr("palpate-scene: there is no scene \"nothing\""));
}

TEST_F(PalpateScene, RefusesAFileThatTakesTooMuchTime) {
  // Replaces the importer by one that never ends, with a shorter limit on its time.
  const std::string scene = folder + "/palpate-scene", importer = folder + "/palpate-import";
  std::filesystem::copy_file(test::OwnFolder() + "/palpate-scene", scene);
  test::WriteFile(importer, "#!/bin/sh\nulimit -t 1\nwhile :; do :; done\n");
  std::filesystem::permissions(importer, std::filesystem::perms::owner_all);
  const std::string file = Write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  test::Program program(scene, {"check", file});
  EXPECT_EQ(program.Exit(60.0), 1);
  EXPECT_THAT(program.Output(),
              testing::AllOf(HasSubstr("palpate-scene: " + file + ": was not read within"),
                             HasSubstr("export it again, or simplify it")));
}

}  // namespace
}  // namespace palpate
