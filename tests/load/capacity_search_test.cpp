#include "client/load/capacity_search.h"

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"

namespace palpate {
namespace {

TEST(CapacitySearch, FindsEveryLimitBelowTheMost) {
  for (std::size_t most = 1; most <= 40; ++most) {
    for (std::size_t limit = 0; limit <= most; ++limit) {
      const Capacity found = FindCapacity(most, 1, [limit](std::size_t n) { return n <= limit; });
      EXPECT_EQ(found.holds, limit) << most;
      EXPECT_EQ(found.fails, limit == most ? 0 : limit + 1) << most;
    }
  }
}

TEST(CapacitySearch, DoublesAndThenBisects) {
  std::vector<std::size_t> tried;
  FindCapacity(1000, 1, [&](std::size_t n) {
    tried.push_back(n);
    return n <= 21;
  });
  EXPECT_THAT(tried, testing::ElementsAre(1, 2, 4, 8, 16, 32, 24, 20, 22, 21));
}

TEST(CapacitySearch, TriesNothingBeyondTheMost) {
  std::vector<std::size_t> tried;
  const Capacity found = FindCapacity(6, 1, [&](std::size_t n) {
    tried.push_back(n);
    return true;
  });
  EXPECT_THAT(tried, testing::ElementsAre(1, 2, 4, 6));
  EXPECT_EQ(found.holds, 6u);
  EXPECT_EQ(FindCapacity(0, 1, [](std::size_t) { return true; }).holds, 0u);
}

TEST(CapacitySearch, BelievesALoadThatFailsOnlyWhenItFailsAgain) {
  int bad_moments = 2;
  const auto holds = [&](std::size_t n) { return n != 8 ? n <= 12 : --bad_moments < 0; };
  EXPECT_EQ(FindCapacity(100, 3, holds).holds, 12u);
  bad_moments = 3;
  EXPECT_EQ(FindCapacity(100, 3, holds).holds, 7u);
}

TEST(CapacitySearch, LetsThroughWhatARunThrows) {
  EXPECT_THROW(FindCapacity(8, 2, [](std::size_t) -> bool { throw Error("no server"); }), Error);
}

}  // namespace
}  // namespace palpate
