#include "client/viewer/signs_of_life.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr std::int64_t kMillisecond_ns = 1'000'000, kBegin_ns = 100'000 * kMillisecond_ns;

TEST(SignsOfLife, AreAskedForOnceASecondAndKeepAViewerThatAnswers) {
  SignsOfLife signs;
  int asked = 0;
  for (std::int64_t ms = 0; ms < 60'000; ++ms) {
    ASSERT_TRUE(signs.Look(kBegin_ns + ms * kMillisecond_ns)) << ms;
    if (!signs.Ask()) continue;
    ++asked;
    signs.Heard();
  }
  EXPECT_NEAR(asked, 60, 1);
}

TEST(SignsOfLife, AreGivenUpAfterThreeSecondsOfSilence) {
  SignsOfLife signs;
  signs.Look(kBegin_ns);
  signs.Heard();
  int asked = 0;
  for (std::int64_t ms = 0; ms <= 3000; ++ms) {
    ASSERT_TRUE(signs.Look(kBegin_ns + ms * kMillisecond_ns));
    asked += signs.Ask();
  }
  EXPECT_EQ(asked, 3);
  EXPECT_FALSE(signs.Look(kBegin_ns + 3001 * kMillisecond_ns));
}

TEST(SignsOfLife, AreNotMissedWhileNobodyLooks) {
  SignsOfLife signs;
  EXPECT_TRUE(signs.Look(kBegin_ns)) << "it has just taken a tool";
  EXPECT_TRUE(signs.Look(kBegin_ns + 10'000 * kMillisecond_ns)) << "the gateway was held up";
  EXPECT_FALSE(signs.Ask()) << "what came meanwhile is yet to be read";
}

}  // namespace
}  // namespace palpate
