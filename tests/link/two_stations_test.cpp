// Stations that want the same name, and stations that misbehave beside one that does not.
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>
#include <unistd.h>

#include "tests/integration/quick_station.h"
#include "tests/integration/rig.h"
#include "tests/support/stall_witness.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

TEST(OneName, IsRefusedToASecondProgramAndTheFirstFeelsNothingOfIt) {
  ServerProgram server("udp");
  ASSERT_TRUE(server.Ready()) << server.Output();
  const std::string file = testing::TempDir() + "palpate_name_" + std::to_string(getpid());
  StationProgram first("hand", "udp", {"--json", file});
  ASSERT_TRUE(server.Says("station hand: active")) << server.Output();
  StationProgram second("hand", "udp");
  EXPECT_EQ(second.Exit(), 1);
  EXPECT_THAT(second.Output(),
              HasSubstr("a station named 'hand' is connected and sends poses; give another --id"));
  first.Signal(SIGTERM);
  EXPECT_EQ(first.Exit(), 0) << first.Output();
  std::ifstream in(file);
  EXPECT_EQ(nlohmann::json::parse(in)["reconnects"], 0);
  std::filesystem::remove(file);
}

TEST(UnreadServer, ServesThoughItsOutputTakesNothing) {
  const std::string full = testing::TempDir() + "palpate_full_" + std::to_string(getpid());
  ASSERT_EQ(mkfifo(full.c_str(), 0600), 0);
  const int fd = open(full.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  while (write(fd, "unread\n", 7) > 0) {
  }
  Program server("/bin/sh",
                 {"-c", R"(exec "$0" cube --transport udp --realtime off --domain "$1" >"$2")",
                  PALPATE_BIN_DIR "/palpate-server", std::to_string(kDomain), full});
  for (const char* const id : {"first", "next"}) {
    StationProgram station(id, "udp", {"--for", "1"});
    EXPECT_EQ(station.Exit(), 0) << station.Output();
    EXPECT_THAT(station.Output(), HasSubstr("session: tool"));
  }
  close(fd);
  std::filesystem::remove(full);
}

/// A server of two scenes; for two seconds a well-behaved station feels one of them.
struct Neighbours : testing::Test {
  const std::string file = testing::TempDir() + "palpate_beside_" + std::to_string(getpid());
  ServerProgram server{"udp", {"cube", "bunny-bunny"}};
  std::unique_ptr<StationProgram> good;
  ~Neighbours() override { std::filesystem::remove(file); }

  void Begin(StallWitness& witness) {
    good = std::make_unique<StationProgram>("good", "udp",
                                            std::vector<std::string>{"--for", "2", "--json", file});
    witness.Watch(server.id());
    witness.Watch(good->id());
  }
  /// Judges what the good station felt.  Spoilt if it lost its session, or too few of its poses
  /// were answered, or too few in time for the limiter to let the force through.
  Attempt End(const char* beside) {
    EXPECT_EQ(good->Exit(), 0) << good->Output();
    std::ifstream in(file);
    const auto summary = nlohmann::json::parse(in);
    std::printf("%-28s late %.4f, lost %.0f, round trip p50 %.0f p99 %.0f us\n", beside,
                static_cast<double>(summary["late_fraction"]), static_cast<double>(summary["lost"]),
                static_cast<double>(summary["rtt_us"]["p50"]),
                static_cast<double>(summary["rtt_us"]["p99"]));
    EXPECT_EQ(summary["limiter"]["nonfinite"], 0);
    EXPECT_LT(summary["force_N_max"], 1.2 * kForce_N);
    if (summary["reconnects"] != 0 || summary["replies"] <= 1000 ||
        summary["force_N_max"] <= 0.8 * kForce_N) {
      return Attempt::kSpoilt;
    }
    EXPECT_EQ(summary["fault_words"], "none");
    return HasFailure() ? Attempt::kFailed : Attempt::kShown;
  }
};

struct Misbehaviour {
  const char* name;
  int per_ms;
  void (*spoil)(wire::HapticPose&);
  const char* told;  ///< what the server logs about it, as a regular expression
};

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kRejected = "bad +bunny-bunny [^\n]* rejected +[1-9]";
/// After a number far ahead no later one is in order, as if no pose came.
constexpr const char* kUnheard = "station bad: ended: no pose came for more than 100 ms";
constexpr const char* kTooMany = "station bad: [0-9]+ poses ignored, beyond its share";

constexpr Misbehaviour kKinds[] = {
    {"NaN", 1, [](wire::HapticPose& pose) { pose.position_m[0] = kNan; }, kRejected},
    {"wild poses", 1,
     [](wire::HapticPose& pose) {
       pose.position_m[0] = pose.pose_sequence % 2 == 0 ? 50.0 : -50.0;
       pose.orientation_wxyz[0] = 1e300;
     },
     kRejected},
    {"wrong sequence", 1,
     [](wire::HapticPose& pose) { pose.pose_sequence *= pose.pose_sequence * 0x9e3779b97f4a7c15; },
     kUnheard},
    {"a clock that jumps", 1,
     [](wire::HapticPose& pose) {
       // Only these are in order then, often enough to keep the session on a busy machine, too.
       pose.sample_time_ns += (pose.pose_sequence % 10 == 0 ? 1 : 0) * 3'600'000'000'000;
     },
     kRejected},
    {"ten times the rate", 10, [](wire::HapticPose&) {}, kTooMany},
    {"fifty times the rate", 50, [](wire::HapticPose&) {}, kTooMany},
};

TEST_F(Neighbours, OfAStationThatLiesOrFloodsAreServedAsBefore) {
  ASSERT_TRUE(server.Says("ready: ", 100.0)) << server.Output();
  EXPECT_TRUE(Shown([&](StallWitness& witness) {
    Begin(witness);
    return End("alone");
  })) << server.Output();

  std::uint64_t run = 0;
  for (const Misbehaviour& kind : kKinds) {
    EXPECT_TRUE(Shown([&](StallWitness& witness) {
      QuickStation bad("bad", "bunny-bunny", dds::Transport::kUdp);
      if (!bad.Begin(++run) || !bad.Answered(10)) {
        return bad.lost_to_silence() ? Attempt::kSpoilt : Attempt::kFailed;
      }
      const std::size_t said_before = server.Output().size();
      Begin(witness);
      std::int64_t next_ns = SteadyNanoseconds();
      while (good->Runs()) {
        // In step with the clock, without a burst after a stall.
        for (int i = 0; i < kind.per_ms; ++i) {
          wire::HapticPose pose = bad.NextPose();
          kind.spoil(pose);
          bad.Send(pose);
        }
        good->Output();
        server.Output();
        next_ns = std::max(next_ns + 1'000'000, SteadyNanoseconds() - 10'000'000);
        const std::int64_t left_ns = next_ns - SteadyNanoseconds();
        if (left_ns > 0) std::this_thread::sleep_for(std::chrono::nanoseconds(left_ns));
      }
      bad.Leave();
      const Attempt felt = End(kind.name);
      // What the server logs shows that it misbehaved at all.
      const std::string said = server.Output().substr(said_before);
      EXPECT_TRUE(server.Runs()) << said;
      // A session that is lost before its first report has none.
      if (!testing::Value(said, testing::ContainsRegex(kind.told))) {
        std::printf("not told: %s", said.c_str());
        return Attempt::kSpoilt;
      }
      return felt == Attempt::kShown && HasFailure() ? Attempt::kFailed : felt;
    })) << kind.name;
  }
}

}  // namespace
}  // namespace palpate::test
