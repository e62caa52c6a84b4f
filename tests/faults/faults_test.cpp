// Each fault of the harness is a test of its own.  The table of all faults is made by hand.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <unistd.h>

#include "tests/support/program.h"
#include "tests/support/stall_witness.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

const std::string kDomain = std::to_string(OwnDomain());

class Faults : public testing::TestWithParam<const char*> {};

std::string NameOf(const testing::TestParamInfo<const char*>& each) {
  std::string name = each.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

TEST_P(Faults, LeaveTrueWhatMustBe) {
  EXPECT_TRUE(Shown([](StallWitness& witness) {
    Program faults(OwnFolder() + "/fault_harness", {"--only", GetParam(), "--domain", kDomain});
    witness.Watch(faults.id());
    if (faults.Exit(220.0) == 0 && faults.Output().find(" held\n") != std::string::npos) {
      return Attempt::kShown;
    }
    std::printf("%s", faults.Output().c_str());
    return faults.Output().find("the station was held up") != std::string::npos ? Attempt::kSpoilt
                                                                                : Attempt::kFailed;
  }));
}
INSTANTIATE_TEST_SUITE_P(Each, Faults,
                         testing::Values("server-killed", "server-frozen", "station-killed",
                                         "station-frozen", "gateway", "gateway-blinded",
                                         "recorder-killed", "recorder-frozen", "disk-full",
                                         "clock-steps", "shm-fills", "no-memory", "hostile-samples",
                                         "forged-cuts", "hostile-port", "slow-loris",
                                         "scene-swapped", "two-servers"),
                         NameOf);
// These run a RouDi of their own, so each has a process of its own.
INSTANTIATE_TEST_SUITE_P(RouDi, Faults, testing::Values("two-roudis", "roudi-killed"), NameOf);

// The programs run with another /tmp, where a build below /tmp has to be found as well.
TEST(FaultsProgram, ShowsThatSharedMemoryIsTooSmallToABuildThatLiesInTmp) {
  namespace fs = std::filesystem;
  const fs::path within = fs::path(OwnFolder()).lexically_relative(PALPATE_SOURCE_DIR);
  if (*within.begin() == "..") GTEST_SKIP() << "the build is not within the sources";
  std::string place = "/tmp/palpate_XXXXXX";
  ASSERT_NE(mkdtemp(place.data()), nullptr);
  Program faults("/usr/bin/unshare",
                 {geteuid() == 0 ? "-m" : "-mr", "sh", "-c",
                  R"(mount --bind "$1" "$2" && exec "$2/$3" --only shm-small --domain "$4")", "sh",
                  PALPATE_SOURCE_DIR, place, within / "fault_harness", kDomain});
  const int status = faults.Exit(220.0);
  fs::remove(place);
  if (faults.Output().starts_with("unshare: ")) GTEST_SKIP() << faults.Output();
  EXPECT_EQ(status, 0) << faults.Output();
  EXPECT_THAT(faults.Output(), testing::HasSubstr(" held\n"));
}

}  // namespace
}  // namespace palpate::test
