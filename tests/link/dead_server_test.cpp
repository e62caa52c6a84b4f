// A server whose successor has another scene, or finds the tool deep inside: what the real station
// gives to its device, tick by tick, from its own trace.  tests/faults kills and freezes servers.
#include <csignal>
#include <filesystem>

#include <gmock/gmock.h>

#include "common/realtime/steady_clock.h"
#include "tests/integration/rig.h"
#include "tests/link/silence.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;
using testing::Not;

struct DeadServer : testing::Test {
  const std::string file = testing::TempDir() + "palpate_dead_" + std::to_string(getpid());
  std::unique_ptr<ServerProgram> server = Server("cube");
  ~DeadServer() override { std::filesystem::remove(file); }

  static std::unique_ptr<ServerProgram> Server(const std::string& scene) {
    auto program = std::make_unique<ServerProgram>("udp", std::vector<std::string>{scene});
    EXPECT_TRUE(program->Ready()) << program->Output();
    return program;
  }
  std::unique_ptr<Program> Station(const std::string& script) const {
    return std::make_unique<Program>(
        PALPATE_BIN_DIR "/palpate-station",
        std::vector<std::string>{"--device", "scripted", "--scene", "cube", "--id", "hand",
                                 "--script", PALPATE_SOURCE_DIR "/tests/link/" + script,
                                 "--realtime", "off", "--transport", "udp", "--domain",
                                 std::to_string(kDomain), "--no-table", "--trace", file});
  }
  std::vector<TraceRow> TraceOf(Program& station) const {
    station.Signal(SIGTERM);
    EXPECT_EQ(station.Exit(), 0) << station.Output();
    return ReadTrace(file);
  }
  static void Wait(double seconds) {
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  }
};

TEST_F(DeadServer, WhoseSuccessorHasAnotherSceneGivesNoForceAndSaysWhy) {
  const auto station = Station("hold.json");
  ASSERT_TRUE(station->Says("session: tool")) << station->Output();
  Wait(1.5);
  server.reset();
  server = Server("ellipsoid");
  EXPECT_EQ(station->Exit(60.0), 1);
  EXPECT_THAT(station->Output(), HasSubstr("the server refuses the session: scene 'cube' is not "
                                           "served here; choose one of: ellipsoid"));
  EXPECT_THAT(station->Output(), HasSubstr("poses sent")) << "what was served is told";
  const std::vector<TraceRow> rows = ReadTrace(file);
  const std::vector<double> silence_ms = CountedSilence_ms(rows);
  double most_N = 0.0;
  std::size_t silent = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const TraceRow& row = rows[i];
    most_N = std::max(most_N, row.applied.force.norm());
    if (row.reply == 0 || silence_ms[i] < kForceGone_ms) continue;
    ++silent;
    ASSERT_TRUE(row.applied.force.isZero(0.0) && row.applied.torque.isZero(0.0)) << row.tick;
  }
  EXPECT_GT(most_N, 5.0);
  EXPECT_GT(silent, 1000u);

  const auto next = Station("hold.json");
  EXPECT_EQ(next->Exit(60.0), 1);
  EXPECT_THAT(next->Output(), HasSubstr("scene 'cube' is not served here"));
  EXPECT_THAT(next->Output(), Not(HasSubstr("poses sent"))) << "none was served";
}

TEST_F(DeadServer, WhoseSuccessorFindsTheToolTooDeepInsideWaitsWithoutAForceAndSaysSo) {
  const auto station = Station("deep.json");
  ASSERT_TRUE(station->Says("session: tool")) << station->Output();
  Wait(2.5);  // 15 mm deep by then
  const std::int64_t killed_ns = SteadyNanoseconds();
  server.reset();
  server = Server("cube");
  EXPECT_TRUE(server->Says("station hand: starts inside an object: the tool is 15 mm inside"))
      << server->Output();
  Wait(1.0);
  const std::vector<TraceRow> rows = TraceOf(*station);
  const std::vector<double> silence_ms = CountedSilence_ms(rows);
  auto dead = rows.begin();
  while (dead != rows.end() &&
         !(dead->time_ns > killed_ns && dead->reply > 0 &&
           silence_ms[static_cast<std::size_t>(dead - rows.begin())] > kForceGone_ms)) {
    ++dead;
  }
  ASSERT_NE(dead, rows.end());
  EXPECT_GT(rows.back().reply, dead->reply) << "it is answered";
  double before_N = 0.0;
  for (auto row = rows.begin(); row != dead; ++row) {
    before_N = std::max(before_N, row->applied.force.norm());
  }
  EXPECT_GT(before_N, 5.0);
  for (auto row = dead; row != rows.end(); ++row) {
    ASSERT_TRUE(row->applied.force.isZero(0.0)) << row->tick;
    ASSERT_TRUE(row->wanted.force.isZero(0.0) || row->reply == dead->reply) << row->tick;
  }
}

}  // namespace
}  // namespace palpate::test
