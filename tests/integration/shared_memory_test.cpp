// The programs over shared memory, and what its transport gets wrong by itself: it forgets chunks
// and knows no domains (common/dds/endpoint.h, common/dds/participant.cpp).
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/common/dds/peer.h"
#include "tests/integration/quick_station.h"
#include "tests/integration/rig.h"
#include "tests/support/roudi.h"
#include "tests/support/stall_witness.h"
#include "tests/support/test_domain.h"

namespace palpate::test {
namespace {

using std::chrono::milliseconds;

const int kForeignDomain = OwnDomain();

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

/// One session of a station: at least so many answers.  Spoilt where the server ended it for the
/// station's silence.
Attempt Answers(QuickStation& station, std::uint64_t run, int answers, bool& uses_shared_memory) {
  const bool answered = station.Begin(run) && station.Answered(answers);
  uses_shared_memory = uses_shared_memory && (!answered || station.uses_shared_memory());
  const bool lost = station.lost_to_silence();
  EXPECT_TRUE(station.Leave()) << "run " << run;
  return answered ? Attempt::kShown : lost ? Attempt::kSpoilt : Attempt::kFailed;
}

TEST(SharedMemory, HearsEachOfTheHundredAndOneRunsOfAStation) {
  RouDi roudi;
  ServerProgram server("shm");
  ASSERT_TRUE(server.Ready()) << server.Output();
  QuickStation station("again");
  std::uint64_t run = 0;
  bool uses_shared_memory = true;
  for (int session = 1; session <= 101; ++session) {
    // At last more than the 257 chunks that a reader can lose.
    const int answers = session <= 100 ? 3 : 300;
    ASSERT_TRUE(Shown([&](StallWitness& witness) {
      witness.Watch(server.id());
      return Answers(station, ++run, answers, uses_shared_memory);
    })) << "run "
        << run << "\n"
        << server.Output();
  }
  EXPECT_TRUE(uses_shared_memory);
}

TEST(SharedMemory, KeepsASessionFromAnotherDomainsWriterOfTheSameTopic) {
  RouDi roudi;
  ServerProgram server("shm");
  ASSERT_TRUE(server.Ready()) << server.Output();
  QuickStation station("mine");
  std::uint64_t run = 6;
  EXPECT_TRUE(Shown([&](StallWitness& witness) {
    witness.Watch(server.id());
    bool kept = station.Begin(++run) && station.Answered(1);
    EXPECT_TRUE(!kept || station.uses_shared_memory());
    Peer foreign("shm", kForeignDomain, dds::PoseTopic("mine", run), 600, "at-once");
    while (kept && foreign.running()) kept = station.Answered(1);
    kept = kept && station.Answered(300);
    // Its poses carry impossible ones: had they come, they would be counted in the lines that the
    // server prints of this session each second.
    for (int line = 0; line < 2; ++line) {
      kept = kept && station.SendUntil([&] { return server.Says(" rejected ", 0.0); });
    }
    const bool lost = station.lost_to_silence();
    EXPECT_TRUE(station.Leave());
    return kept ? Attempt::kShown : lost ? Attempt::kSpoilt : Attempt::kFailed;
  })) << server.Output();
  EXPECT_THAT(server.Output(), testing::Not(testing::ContainsRegex("rejected +[1-9]")));
}

}  // namespace
}  // namespace palpate::test
