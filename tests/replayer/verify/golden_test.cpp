// The physics gives what it gave when the golden recordings were made, on every machine.  Where it
// is meant to give something else: cmake --build --preset release --target golden
#include <algorithm>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/replayer/verify/verify.h"
#include "common/error.h"
#include "scenes/catalogue.h"

namespace palpate::test {
namespace {

std::string FileOf(const std::string& scene) {
  return PALPATE_SOURCE_DIR "/tests/replayer/golden/" + scene + ".mcap";
}

class GoldenRecording : public testing::TestWithParam<std::string> {};

TEST_P(GoldenRecording, GivesTheSameBits) {
  if (!std::filesystem::exists(FileOf(GetParam()))) {
    GTEST_SKIP() << "has no golden recording: whoever has its meshes makes one with "
                    "'make_golden tests/replayer/golden "
                 << GetParam() << "'";
  }
  try {
    const Verification verification = Verify({FileOf(GetParam())}, {});
    EXPECT_TRUE(verification.good()) << ToText(verification);
    ASSERT_EQ(verification.sessions.size(), 1u);
    EXPECT_EQ(verification.sessions[0].scene, GetParam());
  } catch (const Error& error) {
    if (std::string(error.what()).find("is not here") == std::string::npos) throw;
    GTEST_SKIP() << error.what();
  }
}

std::string NameOf(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Catalogue, GoldenRecording, testing::ValuesIn(CatalogueNames()), NameOf);

TEST(GoldenRecordings, AreThereForEverySceneWhoseMeshesAre) {
  for (const std::string& scene : CatalogueNames()) {
    if (scene == "dragon-buddha") continue;  // the Buddha does not come with the project
    EXPECT_TRUE(std::filesystem::exists(FileOf(scene))) << scene;
  }
}

}  // namespace
}  // namespace palpate::test
