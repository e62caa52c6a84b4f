// The scenes of the catalogue, compiled where the C library has fused multiply-add and where it
// has none: glibc chooses its functions by the processor, or as GLIBC_TUNABLES has it.
#include "scenes/catalogue.h"

#include <cstdlib>
#include <filesystem>

#include <gtest/gtest.h>

#include "tests/support/program.h"
#include "tests/support/read_file.h"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;

class CatalogueScene : public testing::TestWithParam<std::string> {
 protected:
  CatalogueScene() { fs::create_directories(folder_); }
  ~CatalogueScene() override { fs::remove_all(folder_); }

  int Run(const std::vector<std::string>& words) {
    Program run("/usr/bin/env", words);
    const int status = run.Exit(200.0);
    said_ = run.Output();
    return status;
  }
  /// Returns the scene's bundle, compiled in the environment given.
  std::string Bundle(std::vector<std::string> environment, const std::string& scene) {
    const std::string file = (folder_ / "bundle").string();
    const int status =
        Run(Joined(environment, {PALPATE_BIN_DIR "/palpate-scene", "build", scene, "-o", file}));
    return status == 0 ? ReadWholeFile(file) : "";
  }

  const fs::path folder_ =
      fs::temp_directory_path() / ("palpate-catalogue-" + std::to_string(getpid()));
  std::string said_;
};

TEST_P(CatalogueScene, HasTheSameBytesAndForcesWithEveryLibM) {
  const std::string scene = GetParam();
  const std::string bytes = Bundle({}, scene);  // or what is in the cache
  if (bytes.empty()) {
    ASSERT_NE(said_.find("is not installed"), std::string::npos) << said_;
    GTEST_SKIP() << said_;
  }
  const std::vector<std::string> other{"GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-AVX2_Usable",
                                       "XDG_CACHE_HOME=" + folder_.string()};
  EXPECT_TRUE(Bundle(other, scene) == bytes) << said_;
  EXPECT_EQ(Run(Joined(other, {PALPATE_BIN_DIR "/palpate-replay", "--verify",
                               PALPATE_SOURCE_DIR "/tests/replayer/golden/" + scene + ".mcap"})),
            0)
      << said_;
}

std::string NameOf(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, CatalogueScene, testing::ValuesIn(CatalogueNames()), NameOf);

}  // namespace
}  // namespace palpate::test
