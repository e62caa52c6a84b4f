#include "server/observation/event_log.h"

#include <memory>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include "common/error.h"
#include "common/program/log.h"
#include "common/step_fault.h"
#include "tests/common/recording/samples.h"
#include "tests/support/milliseconds.h"

namespace palpate::test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class EventLogTest : public testing::Test {
 protected:
  void Tell(const std::string& station, wire::SessionPhase phase, std::int64_t now_ns,
            bool muted = false) {
    wire::SessionState state = SampleState(station, 1);
    state.phase = phase;
    state.muted = muted;
    log_->OnSession(state, now_ns);
  }
  void Fault(std::uint32_t faults, std::int64_t now_ns) {
    wire::LoopStatistics statistics{};
    wire::FromText("hand", statistics.station);
    statistics.faults = faults;
    log_->OnStatistics(statistics, now_ns);
  }
  /// Parses the log; every line must be an object.
  std::vector<nlohmann::json> Lines() const {
    std::vector<nlohmann::json> lines;
    std::ifstream in(file_);
    for (std::string line; std::getline(in, line);) lines.push_back(nlohmann::json::parse(line));
    return lines;
  }
  std::vector<std::string> Events() const {
    std::vector<std::string> events;
    for (const auto& line : Lines()) events.push_back(line["event"]);
    return events;
  }

  Folder folder_;
  std::string file_ = folder_ / "events.jsonl";
  std::unique_ptr<EventLog> log_ = std::make_unique<EventLog>(file_);
};

TEST_F(EventLogTest, TellsASessionFromItsBeginningToItsEnd) {
  log_->OnStart({{"domain", "7"}});
  Tell("hand", palpate_SESSION_WAITING, 1 * kMs);
  Tell("hand", palpate_SESSION_ACTIVE, 2 * kMs);
  Tell("hand", palpate_SESSION_ACTIVE, 3 * kMs);  // repeated
  Tell("hand", palpate_SESSION_ENDED, 3 * kMs);
  Tell("hand", palpate_SESSION_ENDED, 5000 * kMs);  // repeated
  log_.reset();
  EXPECT_THAT(Events(), ElementsAre("start", "begun", "active", "ended", "stop"));
  const auto ended = Lines()[3];
  EXPECT_EQ(ended["station"], "hand");
  EXPECT_FALSE(ended.contains("left_out"));
  EXPECT_EQ(ended["run"], "0000000000000001");
  EXPECT_EQ(ended["scene"], "cube");
  EXPECT_EQ(ended["tool"], "ball");
  EXPECT_EQ(ended["reason"], "as a test wants it");
  EXPECT_EQ(Lines()[0]["domain"], "7");
  EXPECT_THAT(ended["time"].get<std::string>(), testing::MatchesRegex("[-0-9T:.]+Z"));
}

TEST_F(EventLogTest, TellsWhoIsHeldAndMuted) {
  Tell("hand", palpate_SESSION_HELD, 1 * kMs);
  Tell("hand", palpate_SESSION_WAITING, 2 * kMs);
  Tell("hand", palpate_SESSION_ACTIVE, 3 * kMs);
  Tell("hand", palpate_SESSION_ACTIVE, 4 * kMs, true);
  log_->OnUntold(30);
  Tell("hand", palpate_SESSION_ACTIVE, 5 * kMs, false);
  EXPECT_THAT(Events(), ElementsAre("held", "begun", "active", "muted", "unmuted"));
  EXPECT_EQ(Lines().back()["left_out"], 30);
}

TEST_F(EventLogTest, AppendsToWhatIsThere) {
  log_->OnStart({});
  log_.reset();
  log_ = std::make_unique<EventLog>(file_);
  log_->OnStart({});
  log_.reset();
  EXPECT_THAT(Events(), ElementsAre("start", "stop", "start", "stop"));
}

TEST_F(EventLogTest, WritesNoKindOfAStationTwiceASecondAndCountsTheRest) {
  for (int i = 0; i < 100; ++i) Tell("hand", palpate_SESSION_REFUSED, i * 5 * kMs);
  Tell("other", palpate_SESSION_REFUSED, 600 * kMs);
  Tell("hand", palpate_SESSION_REFUSED, 1000 * kMs);
  const auto lines = Lines();
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_FALSE(lines[0].contains("left_out"));
  EXPECT_EQ(lines[1]["station"], "other");
  EXPECT_EQ(lines[1]["left_out"], 99);
  EXPECT_FALSE(lines[2].contains("left_out"));
}

TEST_F(EventLogTest, IsNotFloodedByNamesThatAreMadeUp) {
  for (int i = 0; i < 100'000; ++i) {
    Tell("name" + std::to_string(i), palpate_SESSION_REFUSED, i / 100 * kMs);
  }
  EXPECT_EQ(Lines().size(), static_cast<std::size_t>(EventLog::kMostOfAKind));
}

TEST_F(EventLogTest, TellsFaultsThatAreNew) {
  Fault(kFaultNone, 0);
  Fault(kFaultJammed | kFaultTargetFar, 1000 * kMs);
  Fault(kFaultJammed, 2000 * kMs);
  Fault(kFaultJammed | kFaultRowsFull, 3000 * kMs);
  Fault(kFaultTargetFar | kFaultNotStarted, 4000 * kMs);
  Fault(kFaultJammed, 5000 * kMs);
  std::vector<std::string> faults;
  for (const auto& line : Lines()) faults.push_back(line["faults"]);
  EXPECT_THAT(faults, ElementsAre("jammed", "rows full", "jammed"));
}

TEST_F(EventLogTest, TellsOfScenesThatAreMadeWholeOrNot) {
  wire::SceneWhole whole{};
  wire::FromText("calculus", whole.scene);
  wire::FromText("a teacher", whole.by);
  log_->OnWhole(whole, 0);
  wire::FromText("no object of it can be worn", whole.refusal);
  log_->OnWhole(whole, 0);
  EXPECT_THAT(Events(), ElementsAre("whole", "refused"));
  EXPECT_EQ(Lines()[0]["by"], "a teacher");
  EXPECT_EQ(Lines()[1]["reason"], "no object of it can be worn");
}

TEST_F(EventLogTest, LetsNoNameMakeALineOfItsOwn) {
  Tell("a\"}\n{\"event\":\"x\x1b\xff", palpate_SESSION_REFUSED, 0);
  EXPECT_THAT(Events(), ElementsAre("refused"));
  const std::vector<std::uint8_t> bytes = BytesOf(file_);
  for (std::size_t i = 0; i + 1 < bytes.size(); ++i)
    EXPECT_TRUE(bytes[i] >= ' ' && bytes[i] < 0x7f);
}

TEST_F(EventLogTest, SaysOnceThatTheDiskIsFullAndGoesOn) {
  log_ = std::make_unique<EventLog>("/dev/full");
  testing::internal::CaptureStderr();
  SetUpLog("a-program", "info");
  for (int i = 0; i < 5; ++i) Tell("hand", palpate_SESSION_REFUSED, i * 2000 * kMs);
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_THAT(said, HasSubstr("/dev/full: No space left on device"));
  EXPECT_EQ(said.find("No space"), said.rfind("No space")) << said;
}

TEST_F(EventLogTest, NamesAFileThatCannotBeWritten) {
  EXPECT_THAT([&] { EventLog(folder_ / "none/events.jsonl"); },
              testing::ThrowsMessage<Error>(HasSubstr("none/events.jsonl: No such file")));
}

}  // namespace
}  // namespace palpate::test
