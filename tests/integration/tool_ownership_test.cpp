// One tool, one station: who is second, and who comes after a station that died.
#include <csignal>

#include <gmock/gmock.h>

#include "tests/integration/rig.h"
#include "tests/support/stall_witness.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

/// What the server says, in this order, of a station whose poses stay away.
constexpr const char* kSilent = ": ended: no pose came for more than 100 ms";

/// The first station drives the tool for as long as it sends; that is seen by what the server says,
/// whose lines have the order of its decisions.
Attempt SecondIsRefusedAndThirdFollowsTheDead(StallWitness& witness) {
  ServerProgram server("udp");
  EXPECT_TRUE(server.Ready()) << server.Output();
  witness.Watch(server.id());
  const auto says = [&](const std::string& text) { return server.Output().find(text); };
  constexpr std::size_t kNever = std::string::npos;

  StationProgram first("first", "udp");
  witness.Watch(first.id());
  EXPECT_TRUE(server.Says("station first: active")) << server.Output();
  StationProgram second("second", "udp", {"--for", "1"});
  const int exit = second.Exit();
  const std::size_t lost = says(std::string("station first") + kSilent);
  const std::size_t admitted = says("station second: waits for poses");
  // Whatever the machine does, the tool has one driver: a second one comes after the first's end.
  EXPECT_TRUE(admitted == kNever || lost < admitted) << server.Output();
  if (testing::Test::HasFailure()) return Attempt::kFailed;
  if (lost != kNever) return Attempt::kSpoilt;

  EXPECT_EQ(exit, 1) << second.Output();
  EXPECT_THAT(second.Output(), HasSubstr("is driven by station 'first'"));
  EXPECT_THAT(server.Output(), HasSubstr("station second: refused: tool 'ball' of scene 'cube' is "
                                         "driven by station 'first'"));
  EXPECT_TRUE(first.Runs()) << first.Output();

  first.Signal(SIGKILL);
  EXPECT_EQ(first.Exit(), -SIGKILL);
  // By its silence: nobody has told the server that it died.  How long that lasts, SessionTest and
  // SessionTableTest say in time of their own.
  EXPECT_TRUE(server.Says(std::string("station first") + kSilent)) << server.Output();
  StationProgram third("third", "udp", {"--for", "1.5"});
  EXPECT_EQ(third.Exit(), 0) << third.Output();
  EXPECT_TRUE(server.Says("station third: active")) << server.Output();
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Exit(), 0);
  return testing::Test::HasFailure() ? Attempt::kFailed : Attempt::kShown;
}

TEST(Tool, IsRefusedToASecondStationAndFreeOnceTheFirstHasDied) {
  EXPECT_TRUE(Shown(SecondIsRefusedAndThirdFollowsTheDead));
}

}  // namespace
}  // namespace palpate::test
