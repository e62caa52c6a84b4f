// The programs without RouDi, which manages shared memory, and with one that dies.
#include "tests/support/roudi.h"

#include <csignal>

#include <gmock/gmock.h>

#include "tests/integration/rig.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

constexpr const char* kRemedy = "deploy/cyclonedds/roudi.toml' (same user";
constexpr const char* kFallback = "UDP (no RouDi listens at /tmp/roudi; start 'iox-roudi -c";

TEST(WithoutRouDi, SharedMemoryIsRefusedWithTheRemedyAndAutoTakesUdpAndSaysSo) {
  RouDi roudi;
  roudi.Kill();  // so that no other RouDi runs meanwhile

  ServerProgram insisting_server("shm");
  EXPECT_EQ(insisting_server.Exit(), 1);
  EXPECT_THAT(insisting_server.Output(), HasSubstr(kRemedy));
  StationProgram insisting_station("hand", "shm");
  EXPECT_EQ(insisting_station.Exit(), 1);
  EXPECT_THAT(insisting_station.Output(), HasSubstr(kRemedy));

  ServerProgram server("auto");
  ASSERT_TRUE(server.Ready()) << server.Output();
  EXPECT_THAT(server.Output(), HasSubstr(kFallback));
  StationProgram station("hand", "auto", {"--for", "1"});
  EXPECT_EQ(station.Exit(), 0);
  EXPECT_THAT(station.Output(), HasSubstr(kFallback));
  EXPECT_TRUE(server.Says("station hand: active")) << server.Output();
}

TEST(KilledRouDi, CrashesNeitherServerNorStationAndTheNextSessionUsesUdp) {
  RouDi roudi;
  ServerProgram server("auto");
  ASSERT_TRUE(server.Ready()) << server.Output();
  {
    HeldStation station(dds::Transport::kAuto);
    ASSERT_TRUE(station.UntilForce());
    EXPECT_EQ(station.link().transport().transport, dds::Transport::kSharedMemory);
    roudi.Kill();
    station.For(1.5);
    // Open sessions go on, or lose their force.  A machine that was late for a moment gets time for
    // the ramp.
    EXPECT_TRUE(station.Until([&] {
      const double force_N = station.device.force_N;
      return force_N == 0.0 || std::abs(force_N - kForce_N) < 0.2 * kForce_N;
    })) << station.device.force_N;
    EXPECT_TRUE(server.Says("RouDi has ended", 5.0)) << server.Output();
  }
  ASSERT_TRUE(server.Runs()) << server.Output();
  StationProgram next("next", "auto", {"--for", "1"});
  EXPECT_EQ(next.Exit(), 0) << next.Output();
  EXPECT_THAT(next.Output(), HasSubstr(kFallback));
  EXPECT_TRUE(server.Says("station next: active")) << server.Output();
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Exit(), 0) << server.Output();
}

}  // namespace
}  // namespace palpate::test
