#include "client/viewer/mouse_room.h"

#include <cstdlib>
#include <vector>

#include <gmock/gmock.h>

#include "client/viewer/viewer_limits.h"
#include "common/realtime/steady_clock.h"
#include "tests/support/eventually.h"
#include "tests/support/folder.h"
#include "tests/support/read_file.h"

namespace palpate {
namespace {

using testing::HasSubstr;

constexpr const char* kStation = PALPATE_SOURCE_DIR "/tests/viewer/fake_station";

/// A room with a stand-in for stations: a program that waits for the end of its input, as they do.
class MouseRoomTest : public testing::Test {
 protected:
  void Take(MouseRoom::Holder holder, const std::string& scene = "cube",
            const std::string& absent = "", const std::string& tool = "") {
    TakeIn(room_, holder, "", tool, scene, absent);
  }
  static void TakeIn(MouseRoom& room, MouseRoom::Holder holder, const std::string& who,
                     const std::string& tool = "", const std::string& scene = "cube",
                     const std::string& absent = "") {
    room.Take(holder, who, {MouseCommand::Op::kTake, scene, tool, {}}, absent, SteadyNanoseconds());
  }
  void Session(const std::string& station, wire::SessionPhase phase, const std::string& reason = "",
               std::uint64_t run = 1) {
    wire::SessionState state{};
    state.run = run;
    wire::FromText(station, state.station);
    wire::FromText("ball", state.tool);
    wire::FromText(reason, state.reason);
    state.phase = phase;
    room_.OnSession(state, 0);
  }
  bool ShrinksTo(std::size_t size) {
    return test::Eventually([&] {
      room_.Poll(SteadyNanoseconds());
      return room_.size() == size;
    });
  }

  std::vector<MouseRoom::News> news_;
  MouseRoom room_{{2, 0, "udp", {"lan", {"10.0.0.1"}, {}}, kStation},
                  [this](const MouseRoom::News& news) { news_.push_back(news); }};
};

TEST_F(MouseRoomTest, TellsTheHolderItsStationAndWhatTheServerSaysOfIt) {
  Take(7);
  ASSERT_EQ(news_.size(), 1u);
  EXPECT_EQ(news_[0].holder, 7u);
  EXPECT_EQ(news_[0].station, "mouse_1");
  EXPECT_EQ(news_[0].phase, "");
  Session("mouse_1", palpate_SESSION_WAITING);
  Session("somebody", palpate_SESSION_ACTIVE);
  Session("mouse_1", palpate_SESSION_ACTIVE);
  ASSERT_EQ(news_.size(), 3u);
  EXPECT_EQ(news_[2].phase, "active");
  EXPECT_EQ(news_[2].tool, "ball");
}

TEST_F(MouseRoomTest, KeepsAToolWhoseSessionTheServerEndedBecauseItsStationAsksAgain) {
  Take(7);
  Session("mouse_1", palpate_SESSION_ACTIVE);
  Session("mouse_1", palpate_SESSION_ENDED, "the server stops");
  EXPECT_EQ(news_.back().phase, "");
  EXPECT_EQ(news_.back().reason, "the server stops");
  EXPECT_TRUE(room_.holds(7));
  Session("mouse_1", palpate_SESSION_ACTIVE, "", 2);
  EXPECT_EQ(news_.back().phase, "active") << "it asked under another run";
}

TEST_F(MouseRoomTest, IsNotPutOffByWhatTheServerTellsAnotherStationOfTheSameName) {
  Take(7);
  Session("mouse_1", palpate_SESSION_ENDED, "of its predecessor", 8);
  Session("mouse_1", palpate_SESSION_ACTIVE, "", 1);
  Session("mouse_1", palpate_SESSION_REFUSED, "a station named so is connected", 9);
  Session("mouse_1", palpate_SESSION_ENDED, "of its predecessor", 8);
  EXPECT_EQ(news_.size(), 2u);
  EXPECT_EQ(news_.back().phase, "active");
  EXPECT_TRUE(room_.holds(7));
}

TEST_F(MouseRoomTest, NamesItsStationsByItsPrefixOrTheirHoldersNameAndNeverByAnothers) {
  std::vector<std::string> names;
  const auto note = [&](const MouseRoom::News& news) { names.push_back(news.station); };
  MouseRoom::Options options{8, 0, "udp", {}, kStation, "mouse_ab12_"};
  // There are a token called anna_2 and an arm called ben.
  options.is_others = [](const std::string& station, const std::string& who) {
    return (station == "anna_2" && who != "anna_2") || station == "ben";
  };
  MouseRoom room(options, note);
  MouseRoom::Holder holder = 0;
  for (const char* who : {"", "anna", "anna", "anna_2", "ben", "dr.no-1"}) {
    ++holder;
    TakeIn(room, holder, who, "tool" + std::to_string(holder));
  }
  EXPECT_THAT(names,
              testing::ElementsAre("mouse_ab12_1", "anna", "anna_3", "anna_2", "ben_2", "dr_no_1"));
  // A person who takes the tool again keeps the name: it waits for the station on its way out.
  room.Release(2, "", 0);
  TakeIn(room, ++holder, "anna", "tool2");
  EXPECT_EQ(names.back(), "anna");
  TakeIn(room, ++holder, "anna", "tool2");  // the same tool: the server decides
  EXPECT_EQ(names.back(), "anna_4");
  options.named_prefix = "mouse_";
  MouseRoom secured(options, note);
  TakeIn(secured, 1, "anna");
  EXPECT_EQ(names.back(), "mouse_anna");
}

TEST_F(MouseRoomTest, LetsGoOfAToolThatNobodyMoves) {
  Take(7);
  const std::int64_t now_ns = SteadyNanoseconds();
  room_.Poll(now_ns + ViewerLimits::kMouseIdle_ns / 2);
  room_.Drag(7, Pose{}, false, now_ns + ViewerLimits::kMouseIdle_ns / 2);
  room_.Poll(now_ns + ViewerLimits::kMouseIdle_ns);
  EXPECT_TRUE(room_.holds(7));
  room_.Poll(now_ns + 2 * ViewerLimits::kMouseIdle_ns);
  EXPECT_FALSE(room_.holds(7));
  EXPECT_EQ(news_.back().phase, "ended");
  EXPECT_THAT(news_.back().reason, HasSubstr("5 minutes"));
}

TEST_F(MouseRoomTest, KeepsAToolAtRestForTheViewerThatComesInPlaceOfAMissingOne) {
  Take(7);
  Session("mouse_1", palpate_SESSION_ACTIVE);
  EXPECT_FALSE(room_.Return(7, 8, 0)) << "its viewer is there";
  room_.Rest(7, 1);
  room_.Poll(ViewerLimits::kMouseAway_ns);
  EXPECT_TRUE(room_.Return(7, 8, 2));
  EXPECT_FALSE(room_.holds(7));
  EXPECT_EQ(news_.back().holder, 8u);
  EXPECT_EQ(news_.back().phase, "active");
  room_.Poll(2 * ViewerLimits::kMouseAway_ns);
  EXPECT_TRUE(room_.holds(8)) << "it is not missing any more";
}

TEST_F(MouseRoomTest, LosesAToolWhoseViewerDoesNotComeBackInTime) {
  Take(7);
  Session("mouse_1", palpate_SESSION_ACTIVE);
  room_.Rest(7, 1);
  room_.Rest(7, ViewerLimits::kMouseAway_ns);  // it has been missing since the first
  room_.Poll(ViewerLimits::kMouseAway_ns + 2);
  EXPECT_FALSE(room_.holds(7));
  EXPECT_EQ(news_.back().phase, "ended");
  EXPECT_TRUE(news_.back().lost);
  EXPECT_FALSE(room_.Return(7, 8, 0));
}

TEST_F(MouseRoomTest, WaitsForATeacherAsLongAsThatTakes) {
  Take(7);
  Session("mouse_1", palpate_SESSION_HELD, "waits to be admitted");
  EXPECT_EQ(news_.back().phase, "held");
  room_.Poll(SteadyNanoseconds() + 2 * ViewerLimits::kMouseIdle_ns);
  EXPECT_TRUE(room_.holds(7)) << "nobody can move what has not begun";
  Session("mouse_1", palpate_SESSION_ACTIVE);
  room_.Poll(SteadyNanoseconds() + 2 * ViewerLimits::kMouseIdle_ns);
  EXPECT_FALSE(room_.holds(7));
}

TEST_F(MouseRoomTest, RefusesASecondToolOneTooManyAndScenesThatNobodyServes) {
  Take(7);
  Take(7);
  EXPECT_EQ(news_.back().phase, "refused");
  EXPECT_THAT(news_.back().reason, HasSubstr("release it first"));
  Take(8);
  Take(9);
  EXPECT_THAT(news_.back().reason, HasSubstr("--max-mice"));
  EXPECT_EQ(news_.back().holder, 9u);
  EXPECT_EQ(room_.size(), 2u);
  Take(10, "nowhere", "no server serves scene 'nowhere'");
  EXPECT_EQ(news_.back().reason, "no server serves scene 'nowhere'");
}

TEST_F(MouseRoomTest, KnowsWhichToolsOfASceneOthersHave) {
  Take(7, "cube", "", "ball");
  EXPECT_TRUE(room_.IsTaken("cube", "ball", 8));
  EXPECT_TRUE(room_.IsTaken("cube", "", 8));
  EXPECT_FALSE(room_.IsTaken("cube", "stick", 8));
  EXPECT_FALSE(room_.IsTaken("cube", "ball", 7)) << "the own one";
  EXPECT_FALSE(room_.IsTaken("other", "", 8));
  room_.Release(7, "", 0);
  EXPECT_FALSE(room_.IsTaken("cube", "ball", 8)) << "it is on its way out";
}

TEST_F(MouseRoomTest, LetsGoWhenTheServerRefusesAndPassesOnWhy) {
  Take(7);
  Session("mouse_1", palpate_SESSION_REFUSED, "tool 'ball' is driven by station 'a'");
  EXPECT_EQ(news_.back().phase, "refused");
  EXPECT_EQ(news_.back().reason, "tool 'ball' is driven by station 'a'");
  EXPECT_FALSE(room_.holds(7));
  const std::size_t told = news_.size();
  EXPECT_TRUE(ShrinksTo(0));
  EXPECT_EQ(news_.size(), told) << "its end is no news then";
}

TEST_F(MouseRoomTest, GivesANumberAgainOnlyOnceItsStationHasEnded) {
  Take(7);
  room_.Release(7, "", SteadyNanoseconds());
  EXPECT_EQ(news_.back().phase, "ended");
  Take(7);
  EXPECT_EQ(news_.back().station, "mouse_2");
  room_.Release(7, "", SteadyNanoseconds());
  EXPECT_TRUE(ShrinksTo(0));
  Take(7);
  EXPECT_EQ(news_.back().station, "mouse_1");
}

TEST_F(MouseRoomTest, StartsNoStationWhoseToolIsStillInTheHandOfOneThatLeaves) {
  Take(7);
  room_.Release(7, "", SteadyNanoseconds());
  Take(8);
  Session("mouse_2", palpate_SESSION_ACTIVE);
  EXPECT_EQ(news_.back().phase, "") << "it has not asked";
  EXPECT_TRUE(ShrinksTo(1));
  room_.Poll(SteadyNanoseconds());
  Session("mouse_2", palpate_SESSION_ACTIVE);
  EXPECT_EQ(news_.back().phase, "active");
  room_.Release(8, "", SteadyNanoseconds());
  EXPECT_TRUE(ShrinksTo(0));
}

TEST_F(MouseRoomTest, TellsOfAStationThatFailedWhatItComplainedOf) {
  Take(7, "fail");
  EXPECT_TRUE(ShrinksTo(0));
  EXPECT_EQ(news_.back().phase, "refused");
  EXPECT_EQ(news_.back().reason, "it went wrong");
}

TEST_F(MouseRoomTest, GivesAPagesWordsToTheStationInOneArgumentEach) {
  const test::Folder folder;
  const std::string file = folder / "arguments";
  setenv("PALPATE_FAKE_STATION_ARGUMENTS", file.c_str(), 1);
  for (const std::string word : {"cube --domain=3 $(exit)", "--help", "; exit 1", "*"}) {
    Take(7, word, "", word);
    room_.Release(7, "", SteadyNanoseconds());
    EXPECT_TRUE(ShrinksTo(0));
    EXPECT_EQ(ReadWholeFile(file),
              "--device=mouse\n--scene=" + word +
                  "\n--id=mouse_1\n--domain=0\n--transport=udp\n--network=lan\n--realtime=off\n"
                  "--wait=30\n--no-table\n--peer=10.0.0.1\n--tool=" +
                  word + "\n");
  }
  unsetenv("PALPATE_FAKE_STATION_ARGUMENTS");
}

}  // namespace
}  // namespace palpate
