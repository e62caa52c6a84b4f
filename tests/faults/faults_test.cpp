// Each fault of the harness is a test of its own; the table of them all is by hand.
#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

const std::string kDomain = std::to_string(OwnDomain());

class Faults : public testing::TestWithParam<const char*> {};

TEST_P(Faults, LeaveTrueWhatMustBe) {
  Program faults(OwnFolder() + "/fault_harness", {"--only", GetParam(), "--domain", kDomain});
  EXPECT_EQ(faults.Exit(220.0), 0) << faults.Output();
  EXPECT_THAT(faults.Output(), testing::HasSubstr(" held\n"));
}
INSTANTIATE_TEST_SUITE_P(Each, Faults,
                         testing::Values("server-killed", "server-frozen", "station-killed",
                                         "station-frozen", "gateway", "gateway-blinded",
                                         "recorder-killed", "recorder-frozen", "disk-full",
                                         "clock-steps", "shm-small", "shm-fills", "no-memory",
                                         "hostile-samples", "hostile-port", "slow-loris",
                                         "scene-swapped", "two-servers"),
                         [](const auto& each) {
                           std::string name = each.param;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

TEST(FaultsProgram, NamesAFaultThatThereIsNot) {
  Program faults(OwnFolder() + "/fault_harness", {"--only", "flood"});
  EXPECT_EQ(faults.Exit(20.0), 2);
  EXPECT_THAT(faults.Output(), testing::HasSubstr("--list names all"));
}

}  // namespace
}  // namespace palpate::test
