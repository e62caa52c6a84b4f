#include "common/dds/topics.h"

#include <gtest/gtest.h>

namespace palpate::dds {
namespace {

TEST(Topics, TellStationsAndRunsApart) {
  EXPECT_EQ(PoseTopic("left", 0x2a), "palpate/left/000000000000002a/pose");
  EXPECT_EQ(WrenchTopic("left", 0x2a), "palpate/left/000000000000002a/wrench");
  EXPECT_NE(PoseTopic("left", 1), PoseTopic("left", 2));
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
