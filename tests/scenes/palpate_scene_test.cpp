// The program palpate-scene, as people meet it.

#include <cstdio>
#include <filesystem>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::FreshFolder;
using testing::HasSubstr;

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

TEST(PalpateScene, BuildsABundleAndTellsWhatIsInIt) {
  const std::string folder = FreshFolder();
  const Outcome build = PalpateScene("build ellipsoid -o " + folder + "/e.palpate", folder);
  EXPECT_EQ(build.exit_code, 0) << build.text;
  EXPECT_TRUE(std::filesystem::exists(folder + "/e.palpate"));
  const Outcome info = PalpateScene("info " + folder + "/e.palpate", folder);
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_THAT(info.text, HasSubstr("tool ball: 1 leaves"));
  EXPECT_THAT(info.text, HasSubstr("object ellipsoid: 512 leaves in 3 levels"));
  EXPECT_THAT(info.text, HasSubstr("512 spheres in    64 packets (100 % full)"));
  const Outcome render =
      PalpateScene("render " + folder + "/e.palpate -o " + folder + "/e.png", folder);
  EXPECT_EQ(render.exit_code, 0) << render.text;
  EXPECT_TRUE(std::filesystem::exists(folder + "/e.png"));
}

TEST(PalpateScene, ChecksScenesAndMeshes) {
  const std::string folder = FreshFolder();
  const Outcome scene = PalpateScene("check ellipsoid", folder);
  EXPECT_EQ(scene.exit_code, 0) << scene.text;
  EXPECT_THAT(scene.text, HasSubstr("outside   mean 0.0  p99 0.0  max 0.0 um"));
  EXPECT_THAT(scene.text, HasSubstr("uncovered mean "));
  const std::string mesh =
      test::WriteFile(folder + "/t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const Outcome open = PalpateScene("check " + mesh, folder);
  EXPECT_EQ(open.exit_code, 0) << open.text;
  EXPECT_THAT(open.text, HasSubstr("closed no"));
  EXPECT_THAT(open.text, HasSubstr("note: 3 edges are open"));
}

TEST(PalpateScene, EndsWithOneForAFailureAndTwoForWrongUsage) {
  const std::string folder = FreshFolder();
  for (const std::string wrong :
       {"", "fly", "build", "render cube", "render cube -o x.png --level 9",
        "render cube -o x.png --whole --level 1", "info cube --log-level loud"}) {
    EXPECT_EQ(PalpateScene(wrong, folder).exit_code, 2) << wrong;
  }
  const Outcome missing = PalpateScene("info nothing", folder);
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.text, HasSubstr("palpate-scene: there is no scene \"nothing\""));
}

}  // namespace
}  // namespace palpate
