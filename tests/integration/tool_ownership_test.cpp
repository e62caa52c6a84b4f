// One tool, one station: who is second, and who comes after a station that died.
#include <csignal>
#include <optional>

#include <gmock/gmock.h>

#include "tests/integration/rig.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

TEST(Tool, IsRefusedToASecondStationAndFreeWithinASecondOfTheFirstOnesDeath) {
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready()) << server.Output();
  // Where the machine stands still for 100 ms a station has lost its session, and the other may
  // have the tool: once more, then.
  std::optional<StationProgram> first;
  bool refused = false;
  for (int i = 0; i < 5 && !refused; ++i) {
    first.emplace("first", "udp");
    ASSERT_TRUE(first->Says("session: tool 'ball' of scene 'cube'")) << first->Output();
    ASSERT_TRUE(server.Says("station first: active")) << server.Output();
    StationProgram second("second", "udp", {"--for", "1"});
    const int exit = second.Exit();
    if (exit == 0 || !first->Runs()) continue;
    EXPECT_EQ(exit, 1);
    EXPECT_THAT(second.Output(), HasSubstr("is driven by station 'first'"));
    refused = true;
  }
  EXPECT_TRUE(refused) << server.Output();
  ASSERT_TRUE(first->Runs()) << first->Output();

  first->Signal(SIGKILL);
  EXPECT_EQ(first->Exit(), -SIGKILL);
  EXPECT_TRUE(server.Says("station first: ended", 1.0)) << server.Output();
  StationProgram third("third", "udp", {"--for", "1.5"});
  EXPECT_EQ(third.Exit(), 0) << third.Output();
  EXPECT_TRUE(server.Says("station third: active")) << server.Output();
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Exit(), 0);
}

}  // namespace
}  // namespace palpate::test
