// tests/benchmarks/peers/chai3d, as far as it goes without CHAI3D.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace palpate::bench {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class Chai3dScript : public testing::Test {
 protected:
  /// Runs it, and fills in said_ with its output.
  int Run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--no-build", "--build", folder_ / "b"});
    test::Program program(PALPATE_SOURCE_DIR "/tests/benchmarks/peers/chai3d",
                          std::move(arguments));
    const int status = program.Exit(60.0);
    said_ = program.Output();
    return status;
  }
  void Write(const std::string& name, const std::string& text) const {
    fs::create_directories(fs::path(folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
  }

  std::string said_;
  const test::Folder folder_;
};

TEST_F(Chai3dScript, SaysWhereToGetTheSourcesIfAFolderLacksThem) {
  fs::create_directories(folder_ / "empty");
  EXPECT_EQ(Run({folder_ / "empty"}), 1);
  EXPECT_THAT(said_, HasSubstr("empty has no src/version.h"));
  EXPECT_THAT(said_, HasSubstr("chai3d.org"));
  EXPECT_EQ(Run({folder_ / "nowhere"}), 1);
  EXPECT_THAT(said_, HasSubstr("nowhere has no src/version.h"));
  EXPECT_FALSE(fs::exists(folder_ / "b")) << "it has begun to build";
}

TEST_F(Chai3dScript, RefusesAnotherVersionThanTheOneWhoseFilesItKnows) {
  Write("old/src/version.h", "#define CHAI3D_VERSION \"3.2.0\"\n");
  EXPECT_EQ(Run({folder_ / "old"}), 1);
  EXPECT_THAT(said_, HasSubstr("is version 3.2.0, not 3.3.0"));
}

TEST_F(Chai3dScript, NeedsSourcesAndBuildsOutsideOfTheProjectOnly) {
  EXPECT_EQ(Run({}), 2);
  EXPECT_THAT(said_, HasSubstr("needs the sources of CHAI3D"));
  Write("new/src/version.h", "#define CHAI3D_VERSION \"3.3.0\"\n");
  EXPECT_EQ(Run({folder_ / "new", "--build", PALPATE_SOURCE_DIR "/chai3d"}), 2);
  EXPECT_THAT(said_, HasSubstr("lies in this project"));
}

}  // namespace
}  // namespace palpate::bench
