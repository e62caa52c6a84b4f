#include "common/dds/topics.h"

#include <gtest/gtest.h>

namespace palpate::dds {
namespace {

TEST(Topics, TellStationsAndRunsApart) {
  EXPECT_EQ(PoseTopic("left", 0x2a), "palpate/left/000000000000002a/pose");
  EXPECT_EQ(WrenchTopic("left", 0x2a), "palpate/left/000000000000002a/wrench");
  EXPECT_NE(PoseTopic("left", 1), PoseTopic("left", 2));
}

TEST(Topics, GiveTheirSessionBack) {
  using Session = std::pair<std::string, std::uint64_t>;
  EXPECT_EQ(SessionOfTopic(PoseTopic("left", 0x2a)), Session("left", 0x2a));
  EXPECT_EQ(SessionOfTopic(WrenchTopic("_", ~std::uint64_t{0})), Session("_", ~std::uint64_t{0}));
  for (const char* other :
       {"", "/", "palpate/", "palpate/tool_state", "palpate/a/000000000000002a/pose/",
        "palpate/a/000000000000002a", "palpate/a/2a/pose", "palpate/a/+00000000000002a/pose",
        "palpate/../000000000000002a/pose", "palpate/a/b/000000000000002a/pose",
        "palpate//000000000000002a/pose", "other/a/000000000000002a/pose"}) {
    EXPECT_FALSE(SessionOfTopic(other)) << other;
  }
}

TEST(Topics, StayWithinTheHundredCharactersOfIceoryx) {
  EXPECT_LE(WrenchTopic(std::string(32, 'x'), ~std::uint64_t{0}).size(), 100u);
}

TEST(Topics, TakeLettersDigitsAndUnderscoresAsStationName) {
  for (const char* good : {"a", "Left_2", "0"}) EXPECT_TRUE(IsStationName(good)) << good;
  EXPECT_TRUE(IsStationName(std::string(32, 'x')));
  EXPECT_FALSE(IsStationName(std::string(33, 'x')));
  for (const char* bad : {"", "a b", "a/b", "ä", "a-b", "a*"}) {
    EXPECT_FALSE(IsStationName(bad)) << bad;
  }
}

TEST(Topics, GiveEveryDomainAPairOfItsOwn) {
  for (int domain = 0; domain < kMaxDomain; ++domain) {
    EXPECT_LT(LoopDomainId(domain), ServiceDomainId(domain));
    EXPECT_LT(ServiceDomainId(domain), LoopDomainId(domain + 1));
  }
}

}  // namespace
}  // namespace palpate::dds
