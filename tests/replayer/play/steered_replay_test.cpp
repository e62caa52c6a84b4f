// The replayer as a program, and viewers who steer it over DDS.
#include <cmath>
#include <csignal>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "client/replayer/play/bookmarks.h"
#include "common/dds/cdr_reader.h"
#include "tests/replayer/lesson_recording.h"
#include "tests/replayer/replayer_program.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

/// What a viewer shows of the scene `cube` and of its stations.
struct Picture {
  std::uint64_t server_run = 0;
  std::set<std::uint64_t> gone;                // changes
  std::map<std::string, std::uint64_t> tools;  // pose last shown, by station
  std::set<std::string> sessions;
};

class Guest {
 public:
  ~Guest() { dds::FreeContents(contents); }

  /// Polls until the condition holds; false: it did not.
  template <class Condition>
  bool Sees(Condition condition) {
    return Eventually([&] {
      Poll();
      return condition();
    });
  }
  bool Finds() {
    return Sees([&] { return contents.replay != 0 && wishes_.matched_readers() == 1; });
  }
  /// Asks, and waits for the replay's answer.
  bool Wishes(wire::ReplayWish wish, double value = 0.0, const std::string& text = "") {
    wire::ReplayRequest request{};
    request.kind = wish;
    request.replay = contents.replay;
    request.request = ++last_;
    request.wish = wish;
    request.value = value;
    wire::FromText(text, request.text);
    return wishes_.Write(request) && Sees([&] { return state.request == last_; });
  }
  /// Seeks to `at_s`, where the hand's tool is shown as in the state `tool`.
  bool GoesTo(double at_s, std::uint64_t tool) {
    return Wishes(palpate_REPLAY_SEEK, at_s) &&
           Sees([&] { return state.sought == 1.0 && picture.tools["hand"] == tool; });
  }

  bool Shows(const std::set<std::uint64_t>& gone, const std::set<std::string>& sessions) {
    return Sees([&] { return picture.gone == gone && picture.sessions == sessions; });
  }

  Picture picture;
  wire::ReplayState state{};
  wire::ReplayContents contents{};

 private:
  void Poll() {
    dds::CdrSample raw;
    while (contents_.Take(raw, contents)) {
    }
    while (states_.Take(state)) {
    }
    wire::SceneBundle bundle{};
    while (bundles_.Take(raw, bundle)) IsCurrent(bundle.server_run);
    dds::FreeContents(bundle);
    wire::SolidBlock block{};
    while (blocks_.Take(raw, block)) {
      if (IsCurrent(block.server_run) && block.change > undone_) picture.gone.insert(block.change);
    }
    dds::FreeContents(block);
    wire::SceneWhole whole{};
    while (wholes_.Take(whole)) {
      if (!IsCurrent(whole.server_run)) continue;
      undone_ = whole.last_change;
      std::erase_if(picture.gone, [&](std::uint64_t number) { return number <= undone_; });
    }
    wire::SessionState session{};
    while (sessions_.Take(session)) {
      if (!IsCurrent(session.server_run)) continue;
      picture.sessions.erase(session.station);
      if (session.phase == palpate_SESSION_ACTIVE) picture.sessions.insert(session.station);
    }
    wire::ToolState tool{};
    while (tools_.Take(tool)) picture.tools[tool.station] = tool.pose_sequence;
  }
  bool IsCurrent(std::uint64_t server_run) {
    if (server_run == picture.server_run) return true;
    if (former_.contains(server_run)) return false;
    former_.insert(picture.server_run);
    picture.server_run = server_run;
    picture.gone.clear();
    picture.sessions.clear();
    undone_ = 0;
    return true;
  }

  std::set<std::uint64_t> former_;
  std::uint64_t undone_ = 0, last_ = 0;
  dds::Participant service_ = dds::Participant::Service(kDomain);
  dds::Writer<wire::ReplayRequest> wishes_{service_, dds::kReplayRequestTopic, dds::Qos::kSession};
  dds::CdrReader<wire::ReplayContents> contents_{service_, dds::kReplayContentsTopic,
                                                 dds::Qos::kSession};
  dds::Reader<wire::ReplayState> states_{service_, dds::kReplayStateTopic, dds::Qos::kSession};
  dds::CdrReader<wire::SceneBundle> bundles_{service_, dds::kSceneBundleTopic, dds::Qos::kSession};
  dds::CdrReader<wire::SolidBlock> blocks_{service_, dds::kSolidBlockTopic, dds::Qos::kSession};
  dds::Reader<wire::SceneWhole> wholes_{service_, dds::kSceneWholeTopic, dds::Qos::kSession};
  dds::Reader<wire::SessionState> sessions_{service_, dds::kSessionStateTopic, dds::Qos::kSession};
  dds::Reader<wire::ToolState> tools_{service_, dds::kToolStateTopic, dds::Qos::kRecord};
};

class SteeredReplay : public testing::Test {
 protected:
  SteeredReplay() {
    LessonWriter lesson;
    FillLesson(lesson);
    lesson.Write({.file = file_});
  }
  /// @param more  further options.
  void Begin(const std::vector<std::string>& more = {}) {
    replayer_.emplace(Joined({file_, "--domain", kDomainText}, more));
    ASSERT_TRUE(guest_.Finds()) << replayer_->Output();
  }
  void EndAndCheck() {
    replayer_->Signal(SIGINT);
    EXPECT_EQ(replayer_->Exit(), 0) << replayer_->Output();
    EXPECT_TRUE(guest_.Sees([&] { return guest_.state.ended; }));
    EXPECT_TRUE(guest_.Sees([&] { return guest_.picture.sessions.empty(); }));
  }

  Folder folder_;
  std::string file_ = folder_ / "lesson.mcap";
  std::optional<ReplayerProgram> replayer_;
  Guest guest_;
};

TEST_F(SteeredReplay, ShowsThePlaceThatAViewerSeeksTo) {
  Begin();
  ASSERT_TRUE(guest_.Wishes(palpate_REPLAY_PAUSE));
  EXPECT_FALSE(guest_.state.playing);
  ASSERT_TRUE(guest_.GoesTo(3.01, 3000));
  EXPECT_DOUBLE_EQ(guest_.state.at_s, 3.01);
  EXPECT_TRUE(guest_.Shows({1, 2, 3}, {"hand"})) << "the other has left";
  const std::uint64_t run = guest_.picture.server_run;

  ASSERT_TRUE(guest_.GoesTo(1.0, 1000));
  EXPECT_TRUE(guest_.Shows({}, {"hand", "other"})) << "the scene is as it was then";
  EXPECT_NE(guest_.picture.server_run, run);
  ASSERT_TRUE(guest_.GoesTo(4.5, 3980)) << "in a gap: where the tool was last";
  EXPECT_TRUE(guest_.Shows({1, 2, 3}, {"hand"}));
  ASSERT_TRUE(guest_.GoesTo(5.9, 3980));
  EXPECT_TRUE(guest_.Shows({}, {"hand"})) << "made whole meanwhile";
  ASSERT_TRUE(guest_.GoesTo(9.6, 9600));
  EXPECT_TRUE(guest_.Shows({1}, {"hand"}));
  ASSERT_TRUE(guest_.GoesTo(-5.0, 0)) << "before the beginning";
  EXPECT_EQ(guest_.state.at_s, 0.0);
  ASSERT_TRUE(guest_.GoesTo(1e9, 11'980)) << "after the end";
  EXPECT_DOUBLE_EQ(guest_.state.at_s, 11.98);
  EXPECT_FALSE(guest_.state.playing);
  EndAndCheck();
}

TEST_F(SteeredReplay, ShowsWhoComesWhileItIsPausedWhatTheOthersSee) {
  Begin();
  ASSERT_TRUE(guest_.Wishes(palpate_REPLAY_PAUSE));
  ASSERT_TRUE(guest_.GoesTo(3.01, 3000));
  ASSERT_TRUE(guest_.GoesTo(1.7, 1700));
  Guest late;
  EXPECT_TRUE(late.Finds());
  EXPECT_TRUE(late.Sees([&] { return late.picture.tools["hand"] == 1700; }));
  EXPECT_TRUE(late.Shows({1, 2}, {"hand", "other"}));
  EXPECT_DOUBLE_EQ(late.state.at_s, 1.7);
  EndAndCheck();
}

TEST_F(SteeredReplay, StaysAtItsEndAndShowsItToWhoComesBackAsToWhoPlayedUpToIt) {
  Begin({"--to", "5.5", "--rate", "8", "--stay"});
  const auto shows_the_end = [&] {
    return std::abs(guest_.state.at_s - 5.5) < 1e-6 && guest_.picture.tools["hand"] == 3980;
  };
  ASSERT_TRUE(guest_.Sees([&] { return !guest_.state.playing && shows_the_end(); }));
  EXPECT_TRUE(guest_.Shows({}, {"hand"}));
  ASSERT_TRUE(guest_.GoesTo(0.3, 300));
  ASSERT_TRUE(guest_.GoesTo(5.5, 3980));
  EXPECT_TRUE(guest_.Shows({}, {"hand"}));
  EndAndCheck();
}

TEST_F(SteeredReplay, PlaysOnAtTheRateThatIsWishedAndWaitsAtTheEndForMore) {
  Begin();
  ASSERT_TRUE(guest_.Wishes(palpate_REPLAY_RATE, 8.0));
  EXPECT_EQ(guest_.state.rate, 8.0);
  ASSERT_TRUE(guest_.Sees([&] { return !guest_.state.playing; })) << replayer_->Output();
  EXPECT_DOUBLE_EQ(guest_.state.at_s, 11.98);
  EXPECT_TRUE(replayer_->Runs());
  // It plays from the beginning, where the scene is whole: viewers have to forget.
  const std::uint64_t run = guest_.picture.server_run;
  ASSERT_TRUE(guest_.Wishes(palpate_REPLAY_PLAY));
  ASSERT_TRUE(guest_.Sees([&] { return guest_.picture.server_run != run; }));
  ASSERT_TRUE(guest_.Sees([&] { return !guest_.state.playing; }));
  EXPECT_DOUBLE_EQ(guest_.state.at_s, 11.98);
  EXPECT_TRUE(guest_.Shows({1}, {"hand"}));
  EndAndCheck();
}

TEST_F(SteeredReplay, IsSteeredByNobodyElseWhereItIsLocked) {
  Begin({"--locked", "--step", "--from", "10"});
  EXPECT_TRUE(guest_.contents.locked);
  ASSERT_TRUE(guest_.Wishes(palpate_REPLAY_SEEK, 1.0));
  EXPECT_THAT(guest_.state.refusal, HasSubstr("its own terminal"));
  EXPECT_DOUBLE_EQ(guest_.state.at_s, 10.0);
  ASSERT_TRUE(guest_.Wishes(palpate_REPLAY_PLAY));
  EXPECT_FALSE(guest_.state.playing);
  ASSERT_TRUE(guest_.Wishes(palpate_REPLAY_ADD_BOOKMARK, 1.0, "mine"));
  EXPECT_THAT(guest_.state.refusal, HasSubstr("--locked"));
  EXPECT_FALSE(std::filesystem::exists(Bookmarks::FileFor(file_)));
  EndAndCheck();
}

}  // namespace
}  // namespace palpate::test
