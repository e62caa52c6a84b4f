// Packages and containers, really installed and run: minutes, root, and a mirror of Debian.
#include <cstdlib>

#include <gtest/gtest.h>

#include "tests/house/source_tree.h"

namespace palpate::house {
namespace {

constexpr int kSkipped = 77;

void Try(const std::string& script, const std::string& before) {
  if (std::getenv("PALPATE_TRIALS") == nullptr) {
    GTEST_SKIP() << "takes minutes: " << before << ", then PALPATE_TRIALS=1, or tests/deploy/"
                 << script << " itself";
  }
  const Output output = RunCommand({PALPATE_SOURCE_DIR "/tests/deploy/" + script});
  if (output.exit_code == kSkipped) GTEST_SKIP() << output.text;
  EXPECT_EQ(output.exit_code, 0) << output.text;
}

TEST(Trials, PackagesInstallRunAndLeaveNothingBehindInACleanDebian) {
  Try("try_packages", "deploy/package");
}

TEST(Trials, ServicesRunHardenedAndComeBackWithRouDi) {
  Try("try_services", "deploy/package");
}

TEST(Trials, ContainersAreHealthyWithTheLeastRightsAndAHandFeelsTheScene) {
  Try("try_containers", "deploy/package");
}

TEST(Trials, PodOfAStationHostFeelsTheSceneAndIsStartedAnewWithRouDi) {
  Try("try_pod", "deploy/container/run --try 10");
}

}  // namespace
}  // namespace palpate::house
