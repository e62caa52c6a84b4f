// The programs over shared memory, and what its transport gets wrong: it forgets chunks
// (common/dds/endpoint.h).
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/integration/quick_station.h"
#include "tests/integration/rig.h"
#include "tests/support/roudi.h"
#include "tests/support/stall_witness.h"

namespace palpate::test {
namespace {

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

/// Runs one session of a station with at least so many answers.  Spoilt if the server ended it
/// because the station was silent.
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
    // In the end more than the 257 chunks that a reader can lose.
    const int answers = session <= 100 ? 3 : 300;
    ASSERT_TRUE(Shown([&](StallWitness& witness) {
      witness.Watch(server.id());
      return Answers(station, ++run, answers, uses_shared_memory);
    })) << "run "
        << run << "\n"
        << server.Output();
    if (IsSkipped()) return;
  }
  EXPECT_TRUE(uses_shared_memory);
}

}  // namespace
}  // namespace palpate::test
