#include "common/files/project_files.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/folder.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

class ProjectFiles : public testing::Test {
 protected:
  std::string Make(const std::string& name) const {
    fs::create_directories(folder_ / name);
    return (folder_ / name).string();
  }
  const test::Folder place_;
  const fs::path folder_ = place_.path();
};

TEST_F(ProjectFiles, AreBelowShareOfThePrefixThatTheProgramIsInstalledIn) {
  const std::string bin = Make("usr/bin");
  const std::string catalogue = Make("usr/share/palpate/catalogue");
  EXPECT_EQ(PlaceOf(ProjectFile::kCatalogue, bin), catalogue);
  const std::string models = Make("usr/share/palpate/models/node_modules");
  EXPECT_EQ(PlaceOf(ProjectFile::kModels, bin), models);
}

TEST_F(ProjectFiles, AreInTheCheckoutThatTheProgramIsBuiltIn) {
  const std::string bin = Make("build/release/bin");
  EXPECT_EQ(PlaceOf(ProjectFile::kCatalogue, bin), (folder_ / "scenes/catalogue").string());
  EXPECT_EQ(PlaceOf(ProjectFile::kPage, bin), (folder_ / "build/page").string());
  EXPECT_EQ(PlaceOf(ProjectFile::kModels, bin), (folder_ / "build/models/node_modules").string());
}

TEST_F(ProjectFiles, AreBesideTheProgramsThatTheEnvironmentNames) {
  const std::string own = ProgramFolder();
  setenv("PALPATE_PROGRAMS", "/somewhere/bin", 1);
  EXPECT_EQ(ProgramFolder(), "/somewhere/bin");
  unsetenv("PALPATE_PROGRAMS");
  EXPECT_EQ(ProgramFolder(), own);
}

TEST_F(ProjectFiles, AreShownFromTheWorkingFolderWhereTheyAreBelowIt) {
  const std::string bin = Make("build/release/bin");
  const std::string page = Make("build/page");
  const std::string root = folder_.string();
  EXPECT_EQ(ShownPlaceOf(ProjectFile::kPage, bin, root), "build/page");
  EXPECT_EQ(ShownPlaceOf(ProjectFile::kPage, bin, root + "/build"), "page");
  for (const std::string& elsewhere : {root + "/scenes", std::string("/"), std::string()}) {
    EXPECT_EQ(ShownPlaceOf(ProjectFile::kPage, bin, elsewhere), page);
  }
  // A file that is not in this folder.
  EXPECT_EQ(ShownPlaceOf(ProjectFile::kSharedMemory, bin, root), "deploy/cyclonedds/roudi.toml");
}

TEST_F(ProjectFiles, AreFoundByThisTestInItsCheckout) {
  EXPECT_TRUE(
      fs::equivalent(PlaceOf(ProjectFile::kCatalogue), PALPATE_SOURCE_DIR "/scenes/catalogue"));
  EXPECT_TRUE(fs::is_regular_file(PlaceOf(ProjectFile::kSharedMemory)));
}

TEST_F(ProjectFiles, DoNotComeFromTheWorkingFolderThroughAnEmptyEntryOfThePath) {
  std::ofstream(fs::path(Make("stranger")) / "palpate-import") << "#!/bin/sh\n";
  const fs::path before = fs::current_path();
  const char* const path = std::getenv("PATH");
  const std::string old = path == nullptr ? "" : path;
  const std::string own = ProgramFolder();
  OfferProgramFolder("/nonexistent");
  fs::current_path(folder_ / "stranger");
  for (const char* with : {":/usr/bin", "/nonexistent::/usr/bin", ".:/usr/bin"}) {
    setenv("PATH", with, 1);
    EXPECT_NE(ProgramFolder(), (folder_ / "stranger").string()) << with;
  }
  fs::current_path(before);
  setenv("PATH", old.c_str(), 1);
}

}  // namespace
}  // namespace palpate
