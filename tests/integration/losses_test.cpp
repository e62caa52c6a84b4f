// What a hand feels when its server dies or stands still: no force, and then the force again.
#include <csignal>
#include <filesystem>

#include <gmock/gmock.h>

#include "tests/integration/rig.h"
#include "tests/link/silence.h"
#include "tests/support/roudi.h"

namespace palpate::test {
namespace {

/// What every millisecond of a silence must hold, whatever the machine does: by the limiter's count
/// of time the force is gone in time, and it comes back by a ramp.
struct Losses : testing::Test {
  const std::string file = testing::TempDir() + "palpate_losses_" + std::to_string(getpid());
  ~Losses() override { std::filesystem::remove(file); }

  void ExpectGoneAndBack(HeldStation& station, std::int64_t since_ns) {
    station.End();
    const WrenchLimits limits = WrenchLimits::Of(station.device.info());
    const Silence silence = MeasureSilence(ReadTrace(file), since_ns, limits);
    EXPECT_NEAR(silence.force_before_N, kForce_N, 0.01 * kForce_N);
    EXPECT_LE(silence.counted_until_zero_ms, kForceGone_ms);
    EXPECT_TRUE(silence.stayed_zero);
    EXPECT_LE(silence.largest_step, 1.0);
    // The limiter's ramp lasts 200 ms; a tick counts for no more than its time.
    EXPECT_GT(silence.until_back_ms, 150.0);
  }
};
using KilledServer = Losses;
using StoppedServer = Losses;

TEST_F(KilledServer, LeavesNoForceBehindAndTheStationResumesByItselfWithItsSuccessor) {
  auto server = std::make_unique<ServerProgram>("udp");
  ASSERT_TRUE(server->Ready()) << server->Output();
  HeldStation station(dds::Transport::kUdp, file);
  ASSERT_TRUE(station.UntilForce());

  const std::int64_t killed_ns = SteadyNanoseconds();
  server->Signal(SIGKILL);
  EXPECT_EQ(server->Exit(), -SIGKILL);
  station.For(1.0);
  EXPECT_EQ(station.device.force_N, 0.0);

  server = std::make_unique<ServerProgram>("udp");
  ASSERT_TRUE(server->Ready()) << server->Output();
  EXPECT_TRUE(station.UntilForce());
  EXPECT_EQ(station.link().reconnects(), 1);
  EXPECT_EQ(station.link().PhaseText(), "active");
  ExpectGoneAndBack(station, killed_ns);
}

/// A server that is killed in the middle of a write leaves shared memory locked for good, for RouDi
/// too (common/dds/shared_memory_watch.h).  That is seldom, but then the station must say so.
TEST_F(KilledServer, OverSharedMemoryHasASuccessorOrTheStationSaysWhatMustBeStartedAnew) {
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

TEST_F(StoppedServer, GivesNoForceMeanwhileAndLetsItInByARampAfterwards) {
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready()) << server.Output();
  HeldStation station(dds::Transport::kUdp, file);
  ASSERT_TRUE(station.UntilForce());

  const std::int64_t stopped_ns = SteadyNanoseconds();
  server.Signal(SIGSTOP);
  station.For(0.3);
  EXPECT_EQ(station.device.force_N, 0.0);

  server.Signal(SIGCONT);
  ASSERT_TRUE(station.UntilForce());
  EXPECT_TRUE(server.Runs());
  ExpectGoneAndBack(station, stopped_ns);
}

}  // namespace
}  // namespace palpate::test
