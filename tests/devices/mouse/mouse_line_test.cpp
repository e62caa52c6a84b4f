#include "devices/mouse/mouse_line.h"

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace palpate {
namespace {

bool Parses(std::string_view line) {
  std::string complaint;
  const bool parses = ParseMouseLine(line, complaint).has_value();
  EXPECT_EQ(parses, complaint.empty()) << line;
  return parses;
}

TEST(MouseLine, IsAPoseWhoseRotationIsMadeUnit) {
  std::string complaint;
  const auto line = ParseMouseLine(" 0.1 -0.25 3e-3\t2 0 0 0\r", complaint);
  ASSERT_TRUE(line && line->X_WT);
  EXPECT_EQ(line->X_WT->p, Vec3(0.1, -0.25, 0.003));
  EXPECT_EQ(line->X_WT->q.w(), 1.0);
}

TEST(MouseLine, LetsGo) {
  std::string complaint;
  const auto line = ParseMouseLine("release", complaint);
  ASSERT_TRUE(line);
  EXPECT_FALSE(line->X_WT);
}

TEST(MouseLine, IsNotUsedWhereItIsNoPose) {
  for (const char* line :
       {"", "1 2 3", "0 0 0 1 0 0", "0 0 0 1 0 0 0 0", "a b c d e f g", "0 0 0 1 0 0 0x",
        "nan 0 0 1 0 0 0", "0 nan 0 1 0 0 0", "0 0 nan 1 0 0 0", "inf 0 0 1 0 0 0",
        "0 11 0 1 0 0 0", "0 0 0 0 0 0 0", "0 0 0 nan 0 0 0", "0 0 0 1e300 0 0 0",
        "1e999 0 0 1 0 0 0", "release me", "0,1 0 0 1 0 0 0"}) {
    EXPECT_FALSE(Parses(line)) << line;
  }
}

TEST(MouseLine, GivesFinitePosesOrNoneForAnyBytes) {
  test::Random random(5);
  const std::string_view alphabet = "0123456789+-.eEinfa \t\rrelease";
  int poses = 0;
  for (int i = 0; i < 200'000; ++i) {
    std::string text;
    const bool bytes = random.Below(4) == 0;
    for (int n = static_cast<int>(random.Below(40)); n > 0; --n) {
      text += bytes ? static_cast<char>(random.Below(256))
                    : alphabet[static_cast<std::size_t>(random.Below(alphabet.size()))];
    }
    if (random.Below(2) == 0) text = "1 2 3 4 5 6 " + text;
    std::string complaint;
    const auto line = ParseMouseLine(text, complaint);
    if (!line || !line->X_WT) continue;
    ++poses;
    ASSERT_TRUE(line->X_WT->p.allFinite());
    ASSERT_NEAR(line->X_WT->q.norm(), 1.0, 1e-12);
  }
  EXPECT_GT(poses, 100);
}

}  // namespace
}  // namespace palpate
