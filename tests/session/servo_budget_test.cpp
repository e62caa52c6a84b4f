#include "server/transport/servo_budget.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace palpate::test {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// How many of the poses that come for ten seconds at `per_second` are heard.
int Heard(std::int64_t per_second, std::int64_t begin_ns) {
  ServoBudget budget;
  int heard = 0;
  for (std::int64_t i = 0; i < 10 * per_second; ++i) {
    heard += budget.Take(begin_ns + i * kSecond_ns / per_second, false);
  }
  return heard;
}

TEST(ServoBudget, HearsAThousandPosesASecondAndATenthMoreAndNoMoreThanTheShare) {
  for (const std::int64_t begin_ns : {std::int64_t{0}, 36'000 * kSecond_ns}) {
    EXPECT_EQ(Heard(1000, begin_ns), 10'000);
    EXPECT_EQ(Heard(1100, begin_ns), 11'000);
  }
  EXPECT_NEAR(Heard(10'000, 36'000 * kSecond_ns),
              10 * ServoBudget::kPosesPerSecond + ServoBudget::kPosesAtOnce, 2);
}

TEST(ServoBudget, HearsWhatWaitedDuringAStall) {
  ServoBudget budget;
  ASSERT_TRUE(budget.Take(kSecond_ns, false));
  int heard = 0;
  for (int i = 0; i < 200; ++i) heard += budget.Take(2 * kSecond_ns, false);
  EXPECT_EQ(heard, ServoBudget::kPosesAtOnce);
}

/// For a station that sends a pose a millisecond for ten seconds, each of which takes `step_ns`:
/// its computing time [s] and its longest wait [ms].
struct Given {
  double seconds = 0.0;
  int longest_wait_ms = 0;
};
Given GivenTo(std::int64_t step_ns, bool alone) {
  ServoBudget budget;
  Given given;
  int wait = 0;
  for (std::int64_t ms = 0; ms < 10'000; ++ms) {
    const std::int64_t now_ns = 5 * kSecond_ns + ms * 1'000'000;
    if (!budget.Take(now_ns, alone)) {
      given.longest_wait_ms = std::max(given.longest_wait_ms, ++wait);
      continue;
    }
    wait = 0;
    budget.Took(step_ns, now_ns + step_ns);
    given.seconds += 1e-9 * static_cast<double>(step_ns);
  }
  return given;
}

TEST(ServoBudget, GivesAStationHalfOfTheTimeWhereOthersWantItTooElseAll) {
  EXPECT_NEAR(GivenTo(900'000, false).seconds, 5.0, 0.1);
  EXPECT_NEAR(GivenTo(3'000'000, false).seconds, 5.0, 0.1);
  EXPECT_NEAR(GivenTo(450'000, false).seconds, 4.5, 1e-9) << "less than its share";
  EXPECT_NEAR(GivenTo(900'000, true).seconds, 9.0, 1e-9);
}

TEST(ServoBudget, SilencesNobodyForAsLongAsASessionMayBeSilent) {
  // The longest step that is counted in full: longer ones are the machine's doing.
  EXPECT_LE(GivenTo(80'000'000, false).longest_wait_ms, 20);
}

}  // namespace
}  // namespace palpate::test
