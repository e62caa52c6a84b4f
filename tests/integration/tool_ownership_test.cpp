// One tool, one station: who is second, and who comes after a station that died.
#include <csignal>

#include <gmock/gmock.h>

#include "tests/integration/rig.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

TEST(Tool, IsRefusedToASecondStationAndFreeWithinASecondOfTheFirstOnesDeath) {
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready()) << server.Output();
  StationProgram first("first", "udp");
  ASSERT_TRUE(first.Says("session: tool 'ball' of scene 'cube'")) << first.Output();
  ASSERT_TRUE(server.Says("station first: active")) << server.Output();

  StationProgram second("second", "udp");
  EXPECT_EQ(second.Exit(), 1);
  EXPECT_THAT(second.Output(), HasSubstr("is driven by station 'first'"));
  EXPECT_TRUE(first.Runs());

  first.Signal(SIGKILL);
  EXPECT_EQ(first.Exit(), -SIGKILL);
  EXPECT_TRUE(server.Says("station first: ended", 1.0)) << server.Output();
  StationProgram third("third", "udp", {"--for", "1.5"});
  EXPECT_EQ(third.Exit(), 0) << third.Output();
  EXPECT_TRUE(server.Says("station third: active")) << server.Output();
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Exit(), 0);
}

}  // namespace
}  // namespace palpate::test
