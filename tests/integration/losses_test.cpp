// A server killed in the middle of a write leaves shared memory locked for good, for RouDi as well
// (common/dds/shared_memory_watch.h).  That is rare, but then the station must say so.
#include <chrono>
#include <csignal>
#include <memory>
#include <thread>

#include <gmock/gmock.h>

#include "tests/integration/rig.h"
#include "tests/support/roudi.h"

namespace palpate::test {
namespace {

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
  EXPECT_THAT(station.Output(), testing::HasSubstr("restart iox-roudi"));
}

TEST(KilledServer, WithoutASuccessorBecauseRouDiHangsTheStationSaysWhatMustBeStartedAnew) {
  RouDi roudi;
  auto server = std::make_unique<ServerProgram>("shm");
  ASSERT_TRUE(server->Ready()) << server->Output();
  StationProgram station("hand", "shm");
  ASSERT_TRUE(server->Says("station hand: active")) << server->Output();
  server->Signal(SIGKILL);
  EXPECT_TRUE(station.Says("no replies for 1 s")) << station.Output();
  std::this_thread::sleep_for(std::chrono::seconds(3));  // it has closed its endpoints
  roudi.Hang();
  EXPECT_TRUE(station.Says("restart iox-roudi", 60.0)) << station.Output();
  EXPECT_EQ(station.Exit(), 1);
}

}  // namespace
}  // namespace palpate::test
