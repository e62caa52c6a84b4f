#include "client/viewer/signs_of_life.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

TEST(SignsOfLife, AreAskedForOnceASecondAndKeepAViewerThatAnswers) {
  SignsOfLife signs;
  signs.Heard(100 * kSecond_ns);
  int asked = 0;
  for (std::int64_t ms = 0; ms < 60'000; ++ms) {
    const std::int64_t now_ns = 100 * kSecond_ns + ms * 1'000'000;
    ASSERT_FALSE(signs.gone(now_ns)) << ms;
    if (!signs.Ask(now_ns)) continue;
    ++asked;
    signs.Heard(now_ns + 1'000'000);
  }
  EXPECT_NEAR(asked, 60, 1);
}

TEST(SignsOfLife, AreGivenUpAfterThreeSecondsOfSilence) {
  SignsOfLife signs;
  signs.Heard(100 * kSecond_ns);
  int asked = 0;
  for (std::int64_t ms = 0; ms <= 3000; ++ms) {
    const std::int64_t now_ns = 100 * kSecond_ns + ms * 1'000'000;
    ASSERT_FALSE(signs.gone(now_ns));
    asked += signs.Ask(now_ns);
  }
  EXPECT_EQ(asked, 3);
  EXPECT_TRUE(signs.gone(103 * kSecond_ns + 1));
}

}  // namespace
}  // namespace palpate
