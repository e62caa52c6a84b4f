// The faults for which a RouDi of their own runs: one at a time.
#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

const std::string kDomain = std::to_string(OwnDomain());

class RouDiFaults : public testing::TestWithParam<const char*> {};

TEST_P(RouDiFaults, LeaveTrueWhatMustBe) {
  Program faults(OwnFolder() + "/fault_harness", {"--only", GetParam(), "--domain", kDomain});
  EXPECT_EQ(faults.Exit(220.0), 0) << faults.Output();
  EXPECT_THAT(faults.Output(), testing::HasSubstr(" held\n"));
}
INSTANTIATE_TEST_SUITE_P(Each, RouDiFaults, testing::Values("two-roudis", "roudi-killed"),
                         [](const auto& each) {
                           std::string name = each.param;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace palpate::test
