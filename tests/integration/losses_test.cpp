// What a hand feels when its server dies or stands still: no force, and then the force again.
#include <csignal>

#include <gmock/gmock.h>

#include "tests/common/dds/roudi.h"
#include "tests/integration/rig.h"

namespace palpate::test {
namespace {

TEST(KilledServer, LeavesNoForceBehindAndTheStationResumesByItselfWithItsSuccessor) {
  auto server = std::make_unique<ServerProgram>("udp");
  ASSERT_TRUE(server->Ready()) << server->Output();
  HeldStation station(dds::Transport::kUdp);
  ASSERT_TRUE(station.UntilForce());

  const std::int64_t killed_ns = SteadyNanoseconds();
  server->Signal(SIGKILL);
  EXPECT_EQ(server->Exit(), -SIGKILL);
  station.For(1.0);
  EXPECT_EQ(station.device.force_N, 0.0);
  EXPECT_LT(station.device.last_force_ns - killed_ns, kForceGone_ns);

  server = std::make_unique<ServerProgram>("udp");
  ASSERT_TRUE(server->Ready()) << server->Output();
  EXPECT_TRUE(station.UntilForce());
  EXPECT_EQ(station.link().reconnects(), 1);
  EXPECT_EQ(station.link().PhaseText(), "active");
}

/// A server that is killed in the middle of a write leaves shared memory locked for good, for RouDi
/// too (common/dds/shared_memory_watch.h).  That is seldom, but then the station must say so.
TEST(KilledServer, OverSharedMemoryHasASuccessorOrTheStationSaysWhatMustBeStartedAnew) {
  RouDi roudi;
  auto server = std::make_unique<ServerProgram>("shm");
  ASSERT_TRUE(server->Ready()) << server->Output();
  StationProgram station("hand", "shm");
  ASSERT_TRUE(station.Says("session: tool 'ball' of scene 'cube'")) << station.Output();
  ASSERT_TRUE(server->Says("station hand: active")) << server->Output();
  server->Signal(SIGKILL);
  EXPECT_EQ(server->Exit(), -SIGKILL);
  EXPECT_TRUE(station.Says("no replies for 1 s: forces are zero")) << station.Output();

  server = std::make_unique<ServerProgram>("shm");
  if (station.Says("session resumed: forces ramp in", 60.0)) {
    station.Signal(SIGTERM);
    EXPECT_EQ(station.Exit(), 0) << station.Output();
    return;
  }
  EXPECT_EQ(station.Exit(), 1);
  EXPECT_THAT(station.Output(), testing::HasSubstr("start iox-roudi anew"));
}

TEST(StoppedServer, GivesNoForceMeanwhileAndLetsItInByARampAfterwards) {
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready()) << server.Output();
  HeldStation station(dds::Transport::kUdp);
  ASSERT_TRUE(station.UntilForce());

  const std::int64_t stopped_ns = SteadyNanoseconds();
  server.Signal(SIGSTOP);
  station.For(0.3);
  EXPECT_EQ(station.device.force_N, 0.0);
  EXPECT_LT(station.device.last_force_ns - stopped_ns, kForceGone_ns);

  server.Signal(SIGCONT);
  ASSERT_TRUE(station.UntilForce());
  // The limiter's ramp lasts 200 ms, most of it between a tenth and nine tenths of the force.
  EXPECT_GT(station.device.last_rising_ns - station.device.last_weak_ns, kSecond_ns / 20);
  EXPECT_TRUE(server.Runs());
}

}  // namespace
}  // namespace palpate::test
