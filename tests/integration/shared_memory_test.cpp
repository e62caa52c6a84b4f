// The programs over shared memory, and what its transport gets wrong by itself: it forgets chunks
// and knows no domains (common/dds/endpoint.h, common/dds/participant.cpp).
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/common/dds/peer.h"
#include "tests/common/dds/roudi.h"
#include "tests/integration/quick_station.h"
#include "tests/integration/rig.h"

namespace palpate::test {
namespace {

using std::chrono::milliseconds;

constexpr int kForeignDomain = 35;

TEST(SharedMemory, CarriesTheForceFromTheServerToTheStation) {
  RouDi roudi;
  ServerProgram server("auto");
  ASSERT_TRUE(server.Ready()) << server.Output();
  EXPECT_THAT(server.Output(), testing::HasSubstr("transport shared memory (RouDi answers)"));
  const std::string file = testing::TempDir() + "/palpate_" + std::to_string(getpid()) + ".json";
  StationProgram station("hand", "shm", {"--for", "1.5", "--json", file});
  ASSERT_EQ(station.Exit(), 0) << station.Output();
  std::ifstream in(file);
  const auto summary = nlohmann::json::parse(in);
  std::filesystem::remove(file);
  EXPECT_EQ(summary["transport"], "shared memory");
  EXPECT_NEAR(summary["force_N_max"], kForce_N, 0.2 * kForce_N);
  EXPECT_GT(summary["replies"], 300);
  server.Signal(SIGTERM);
  EXPECT_EQ(server.Exit(), 0) << server.Output();
}

TEST(SharedMemory, HearsTheHundredAndFirstRunOfAStation) {
  RouDi roudi;
  ServerProgram server("shm");
  ASSERT_TRUE(server.Ready()) << server.Output();
  QuickStation station("again");
  std::uint64_t run = 1;
  int held_up = 0;  // a session ends where the machine stands still for 100 ms
  for (; run <= 100 + static_cast<std::uint64_t>(held_up); ++run) {
    ASSERT_TRUE(station.Begin(run)) << "run " << run << "\n" << server.Output();
    held_up += !station.Answered(3);
    ASSERT_LE(held_up, 2) << "run " << run << "\n" << server.Output();
    ASSERT_TRUE(station.Leave()) << "run " << run << "\n" << server.Output();
  }
  const auto heard = [&] {
    if (station.Begin(run++) && station.Answered(300)) return true;
    station.Leave();
    return false;
  };
  EXPECT_TRUE(heard() || heard() || heard()) << "more than the 257 chunks that a reader can lose";
  EXPECT_TRUE(station.uses_shared_memory());
}

TEST(SharedMemory, KeepsASessionFromAnotherDomainsWriterOfTheSameTopic) {
  RouDi roudi;
  ServerProgram server("shm");
  ASSERT_TRUE(server.Ready()) << server.Output();
  QuickStation station("mine");
  // Where the machine stands still for 100 ms the session ends: once more, then.
  std::uint64_t run = 7;
  const auto keeps = [&] {
    bool kept = station.Begin(run) && station.Answered(1);
    Peer foreign("shm", kForeignDomain, dds::PoseTopic("mine", run++), 600, "at-once");
    while (foreign.running()) kept = kept && station.Answered(1);
    kept = kept && station.Answered(300);
    EXPECT_TRUE(station.Leave());
    return kept;
  };
  EXPECT_TRUE(keeps() || keeps() || keeps()) << server.Output();
  // Its poses carry impossible ones: had they come, they would have been counted.
  EXPECT_THAT(server.Output(), testing::Not(testing::ContainsRegex("rejected +[1-9]")));
}

}  // namespace
}  // namespace palpate::test
