#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gmock/gmock.h>

#include "devices/plugin/plugin_device.h"
#include "server/library/scenes.h"
#include "tests/support/complaint.h"
#include "tests/support/effects_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

/// The library, installed in a new place.
class Installed : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(Run(std::string(PALPATE_CMAKE) + " --install " + PALPATE_BUILD_DIR + " --prefix " +
                  Prefix()),
              0)
        << said_;
  }
  std::string Prefix() const { return (folder_ / "usr").string(); }
  /// Runs a command in a shell; returns its exit status, and puts its output into `said_`.
  int Run(const std::string& command) {
    Program shell("/bin/sh", {"-c", command});
    const int status = shell.Exit(250.0);
    said_ = shell.Output();
    return status;
  }

  const Folder place_;
  const fs::path folder_ = place_.path();
  std::string said_;
};

TEST_F(Installed, ExamplesBuildAgainstItAndFeelWhatTheyShould) {
  const std::string build = (folder_ / "examples").string();
  ASSERT_EQ(
      Run(std::string(PALPATE_CMAKE) + " -S " PALPATE_SOURCE_DIR "/client/examples -B " + build +
          " -D CMAKE_BUILD_TYPE=Release -D CMAKE_CXX_COMPILER_LAUNCHER= -D CMAKE_PREFIX_PATH=" +
          Prefix() + " && " PALPATE_CMAKE " --build " + build + " --parallel 2"),
      0)
      << said_;
  ASSERT_EQ(Run(build + "/first_force"), 0) << said_;
  EXPECT_THAT(said_, HasSubstr("hand at 22.0 mm, probe at 25.0 mm"));
  EXPECT_THAT(said_, HasSubstr("3.00 "));
  ASSERT_EQ(Run(build + "/first_force_c"), 0) << said_;
  EXPECT_THAT(said_, HasSubstr("ball at 25.0 mm, force 3.00 N"));
  ASSERT_EQ(Run(build + "/own_loop 0.5"), 0) << said_;
  EXPECT_THAT(said_, HasSubstr("500 steps"));
  ASSERT_EQ(Run(build + "/own_material"), 0) << said_;
  EXPECT_THAT(said_, HasSubstr("hard and rough   press 3.0"));
  ASSERT_EQ(Run("PATH=" PALPATE_BIN_DIR ":$PATH " + build + "/first_scene cube"), 0) << said_;
  EXPECT_THAT(said_, HasSubstr("cube: ball feels"));
  // It needs no DDS, assimp or the like.
  ASSERT_EQ(Run("cd " + build + " && ldd first_force first_force_c first_scene"), 0) << said_;
  for (const char* library :
       {"dds", "assimp", "boost", "png", "spdlog", "fmt", "xxhash", "flatbuffers"}) {
    EXPECT_THAT(said_, Not(HasSubstr(std::string("lib") + library)));
  }
}

TEST_F(Installed, ComponentsAreFoundOrMissedByName) {
  const auto find = [&](const std::string& components) {
    std::ofstream(folder_ / "CMakeLists.txt")
        << "cmake_minimum_required(VERSION 3.20)\nproject(x LANGUAGES CXX)\n"
        << "find_package(palpate REQUIRED COMPONENTS " << components << ")\n"
        << "foreach(component " << components << ")\n  if(NOT TARGET palpate::${component})\n"
        << "    message(FATAL_ERROR \"no target\")\n  endif()\nendforeach()\n";
    return Run(std::string(PALPATE_CMAKE) + " -S " + folder_.string() + " -B " +
               (folder_ / "components").string() + " -D CMAKE_PREFIX_PATH=" + Prefix());
  };
  for (const char* components : {"physics", "c", "physics scenes device effect"}) {
    EXPECT_EQ(find(components), 0) << components << said_;
  }
  EXPECT_NE(find("physics tissue"), 0);
  EXPECT_THAT(said_, HasSubstr("`tissue`"));
}

TEST_F(Installed, DriverOfOnesOwnBuildsWithoutEigenAndIsLoaded) {
  const std::string build = (folder_ / "own_arm").string(),
                    source = PALPATE_SOURCE_DIR "/client/examples/own_arm";
  // From a copy, so that nothing of the source tree is in reach.
  ASSERT_EQ(Run("cp -r " + source + " " + build + ".c && " PALPATE_CMAKE " -S " + build + ".c -B " +
                build + " -D CMAKE_C_COMPILER_LAUNCHER= -D CMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON" +
                " -D CMAKE_PREFIX_PATH=" + Prefix() + " && " PALPATE_CMAKE " --build " + build),
            0)
      << said_;
  DeviceOptions options;
  options.name = build + "/libvirtual_arm.so";
  PluginDevice arm(options);
  arm.Turn([] {});
  EXPECT_NEAR(arm.Read().X_WH.p.y(), 0.038, 1e-5);
  EXPECT_THAT(arm.info().model, HasSubstr("virtual arm"));
  options.arm = "another";
  EXPECT_THAT(ComplaintOf([&] { PluginDevice{options}; }), HasSubstr("leave --device-name out"));
  const auto lines = [&](const char* file) {
    const auto text = BytesOf(source + file);
    return std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_LE(lines("/virtual_arm.c"), 100);
  EXPECT_LE(lines("/CMakeLists.txt"), 5);
}

TEST_F(Installed, EffectsOfOnesOwnBuildWithoutEigenAndAreFelt) {
  const std::string source = PALPATE_SOURCE_DIR "/client/examples/effects",
                    own = (folder_ / "own").string();
  ASSERT_EQ(
      Run("cp -r " + source + " " + own + " && " PALPATE_CMAKE " -S " + own + " -B " + own +
          "/build -D CMAKE_C_COMPILER_LAUNCHER= -D CMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON" +
          " -D CMAKE_PREFIX_PATH=" + Prefix() + " && " PALPATE_CMAKE " --build " + own + "/build"),
      0)
      << said_;
  std::ofstream(own + "/mine.json")
      << CubeWithEffects(R"({"name": "build/vibration.so", "along": [0, 0, 1], "rate_Hz": 0.1})");
  const TrustedEffects trusted(own + "/build");
  const Scene scene = LoadScene(own + "/mine.json");
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  EXPECT_EQ(Proxy(model, scene.tools[0].X_WB).Step(scene.tools[0].X_WB).wrench.force.z(), 0.3);
  for (const auto& file : fs::directory_iterator(source)) {
    const auto text = BytesOf(file.path().string());
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 40) << file.path();
  }
}

TEST_F(Installed, FirstForceTakesThirtyLinesAtMost) {
  const auto text = BytesOf(PALPATE_SOURCE_DIR "/client/examples/first_force.cpp");
  EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 30);
}

TEST_F(Installed, IsFoundByPkgConfig) {
  const std::string source = (folder_ / "own.cpp").string(), program = (folder_ / "own").string();
  std::ofstream(source)
      << "#include <palpate/physics.h>\n"
         "#include \"common/error.h\"\n"  // the user's own, which palpate's must not hide
         "int main() { return palpate::MakeBall(\"b\", kMine).tree.leaves() == 1 ? 0 : 1; }\n";
  fs::create_directories(folder_ / "mine/common");
  std::ofstream(folder_ / "mine/common/error.h") << "constexpr double kMine = 0.01;\n";
  const std::string flags = "$(PKG_CONFIG_PATH=$(dirname $(find " + Prefix() +
                            " -name palpate.pc)) pkg-config --cflags --libs ";
  ASSERT_EQ(Run("g++ -std=c++20 -mavx2 -Wall -Wextra -I" + (folder_ / "mine").string() + " " +
                source + " -o " + program + " " + flags + "palpate-physics) && " + program),
            0)
      << said_;
  ASSERT_EQ(Run("gcc -std=c11 -Wall -Wextra -Wpedantic -Werror " PALPATE_SOURCE_DIR
                "/client/examples/first_force.c -o " +
                program + " " + flags + "palpate) && LD_LIBRARY_PATH=$(dirname $(find " + Prefix() +
                " -name libpalpate.so)) " + program),
            0)
      << said_;
}

TEST_F(Installed, SaysWhereEigenIsAlignedOtherwise) {
  const std::string source = (folder_ / "avx.cpp").string();
  std::ofstream(source) << "#include <palpate/physics.h>\nint main() {}\n";
  EXPECT_NE(Run("g++ -std=c++20 -mavx2 -fsyntax-only $(pkg-config --cflags eigen3) -I" + Prefix() +
                "/include " + source),
            0);
  EXPECT_THAT(said_, HasSubstr("-DEIGEN_MAX_STATIC_ALIGN_BYTES=16"));
}

TEST_F(Installed, CLibraryShowsItsOwnNamesAlone) {
  ASSERT_EQ(
      Run("nm -D --defined-only $(find " + Prefix() + " -name libpalpate.so) | awk '{print $3}'"),
      0);
  std::istringstream names(said_);
  int count = 0;
  for (std::string name; std::getline(names, name); ++count) {
    EXPECT_TRUE(name.starts_with("palpate_")) << name;
  }
  EXPECT_GT(count, 10);
}

}  // namespace
}  // namespace palpate::test
